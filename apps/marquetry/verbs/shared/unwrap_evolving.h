#pragma once
/// One atlas for all frames of an evolving mesh: unwrap X.evolving -o Y.evolving, and the end of
/// evolve.

#include <filesystem>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/unwrap/unwrap.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Whether a file is named like the store of an evolving mesh.
bool names_evolving(const std::filesystem::path& path);

/// Adds --size, --gutter, --stretch and --trials.
void add_atlas_options(OptionTable& table);

/// What they say.
UnwrapOptions asked_atlas(const OptionValues& options);

/// Adds --coherence, --renew, --picture and --view, which only evolving meshes have.
void add_evolving_atlas_options(OptionTable& table);

/// Gives a store an atlas, as `output`, which may be the same; adds to the result, and to each of its
/// frames where there are any.
void unwrap_store(Run& run, const EvolvingReader& reader, const std::filesystem::path& output,
                  double share);

/// All files that are written.
std::vector<std::filesystem::path> store_paths(const OptionValues& options);

/// The verb, for an evolving mesh.
Exit unwrap_evolving(Run& run);

}  // namespace mq::app
