#pragma once
/// unwrap X.evolving -o Y.evolving: one atlas for all frames of an evolving mesh.

#include "run.h"
#include "verb.h"

namespace mq::app {

/// Whether a file is named like the store of an evolving mesh.
bool names_evolving(const std::filesystem::path& path);

/// Adds --coherence, --picture and --view, which only evolving meshes have.
void add_evolving_atlas_options(OptionTable& table);

Exit unwrap_evolving(Run& run);

}  // namespace mq::app
