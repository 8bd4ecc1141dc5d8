#pragma once
/// What track and evolve have in common: a sequence followed with one triangulation.

#include <filesystem>
#include <vector>

#include "mq/model/template_follower.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Options of other names than the library's fields have (see `Verb`).
OptionFields tracking_fields();

/// The sequence, the output, and how it is followed; all but whether it is remeshed.
void add_tracking_options(OptionTable& table);

/// How well a remeshed frame must be shown; for verbs that remesh.
void add_remeshing_options(OptionTable& table);

/// --shard, for a verb that can leave the rest of a sequence to others; with it --output has a place for the part's number.
void add_part_option(OptionTable& table);

/// Where what follows the sequence is stored.
std::filesystem::path followed_store(const OptionValues& options);

/// The files that following makes: the store's two, and the pictures asked for.
std::vector<std::filesystem::path> followed_paths(const OptionValues& options);

/// Follows the sequence of the options and stores it in the output, a frame at a time; where it is
/// remeshed, --keyframes says how. Prints a table; returns what was measured: `frames`, `skipped`,
/// `distance_p95`, `distance_max`, `folded`; null with --dry-run.
Json track_sequence(Run& run, Remeshing remeshing, double share);

}  // namespace mq::app
