#pragma once
/// export X.evolving --from SEQUENCE: what was captured, as textures of an evolving mesh's atlas, or
/// where it has none as colours at its vertices.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/io/evolving_file.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --from, --texture, --size and --samples.
void add_captured_texture_options(OptionTable& table);

/// The files that frames with these numbers make. Throws `InvalidInput` where --output cannot hold
/// what is captured: without an atlas only models do.
std::vector<std::filesystem::path> captured_paths(const OptionValues& options,
                                                  const EvolvingReader& reader,
                                                  const std::vector<int>& numbers);

/// Resamples the captured frames one by one and writes them to `to`, as `FrameTextures` takes it, or
/// to an animation; adds `textures` to the result: of each frame its number, texels of charts and
/// those of them that nothing was captured for. Without an atlas models have colours at vertices
/// instead.
void write_captured_textures(Run& run, const EvolvingReader& reader,
                             const std::vector<int>& frames, const std::string& to);

}  // namespace mq::app
