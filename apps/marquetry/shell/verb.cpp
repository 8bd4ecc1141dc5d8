#include "shell/verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "shell/run.h"

namespace mq::app {

#define MARQUETRY_VERB(name) Verb name##_verb();
#include "verb_list.inc"
#undef MARQUETRY_VERB

std::vector<Verb> all_verbs() {
  return {
#define MARQUETRY_VERB(name) name##_verb(),
#include "verb_list.inc"
#undef MARQUETRY_VERB
  };
}

namespace {

/// What other programs call what `filter` does.
bool sharpens_or_smooths(const std::string& name) {
  static const std::set<std::string> names = {"sharpen", "smooth", "blur", "unsharp"};
  return names.contains(name);
}

}  // namespace

Verb find_verb(const std::vector<Verb>& verbs, const std::string& name) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs) {
    if (verb.table.verb() == name) {
      Verb found = verb;
      add_running_options(found.table);
      return found;
    }
    names.push_back(verb.table.verb());
  }
  const std::string hint = sharpens_or_smooths(name)
                               ? ": 'filter --strength 50%' sharpens, 'filter --strength -100%' smooths"
                               : did_you_mean(name, names);
  throw InvalidInput(fmt::format("there is no verb '{}'{} ('marquetry --help' lists them)", name, hint));
}

void name_options_of(const Verb& verb) {
  set_option_names([fields = verb.fields, options = verb.table.options()](std::string_view field) {
    std::string name(field);
    if (const auto other = fields.find(field); other != fields.end())
      name = other->second;
    else
      std::ranges::replace(name, '_', '-');
    const auto option = std::ranges::find(options, name, &Option::name);
    return option == options.end() ? name : display_name(*option);
  });
}

}  // namespace mq::app
