#pragma once
/// Help without repetition: the options that several verbs share word for word are listed once,
/// those of one verb without them. `marquetry help VERB` and `marquetry help options` print this,
/// and docs/ has it on its pages.

#include <string>
#include <vector>

#include "shell/verb.h"

namespace mq::app {

/// An option is shared where at least this many verbs have it in the same words.
inline constexpr int least_sharing_verbs = 3;

/// Usage, summary, the verb's own options in full, and the names of those it shares. Throws
/// `InvalidInput` where there is no such verb.
std::string own_help(const std::vector<Verb>& verbs, const std::string& name);

/// The options that verbs share, by group. Of several wordings of one name the most frequent.
std::string shared_help(const std::vector<Verb>& verbs);

}  // namespace mq::app
