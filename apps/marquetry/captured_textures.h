#pragma once
/// export X.evolving --from SEQUENCE: what was captured, as textures of an evolving mesh's atlas.

#include <string>
#include <vector>

#include "mq/io/evolving_file.h"
#include "run.h"

namespace mq::app {

/// Adds --from, --texture, --size and --samples.
void add_captured_texture_options(OptionTable& table);

/// Resamples the captured frames one by one and writes them to `to`, as `FrameTextures` takes
/// it; adds `textures` to the result: of each
/// frame its number, texels of charts and those of them that nothing was captured for.
void write_captured_textures(Run& run, const EvolvingReader& reader,
                             const std::vector<int>& frames, const std::string& to);

}  // namespace mq::app
