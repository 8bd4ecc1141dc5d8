#pragma once
/// One texture atlas for all frames of a stored evolving mesh.
///
///     const EvolvingReader reader("bare.evolving");
///     EvolvingMesh evolving = read_frames(reader);
///     const LifespanAtlas atlas = lay_out_stored(reader, evolving);
///     write_laid_out(reader, evolving, "body.evolving");

#include <filesystem>
#include <string>

#include "mq/base/progress.h"
#include "mq/evolving/evolving_mesh.h"
#include "mq/evolving/lifespan_atlas.h"
#include "mq/io/evolving_file.h"

namespace mq {

/// All that a store holds. Throws `InvalidInput` where it holds no frame, and as
/// `EvolvingReader::read` does.
EvolvingMesh read_frames(const EvolvingReader& reader);

/// `lay_out` of what was read, whose refusals name the store.
LifespanAtlas lay_out_stored(const EvolvingReader& reader, EvolvingMesh& evolving,
                             const LifespanAtlasOptions& options = {},
                             const Progress& progress = {});

/// Writes the mesh as another store, or in place of the one it was read from: with the same step, groups as long,
/// and what was measured of its frames. `about` and `uv_step` are as `EvolvingWriter` has them.
void write_laid_out(const EvolvingReader& reader, const EvolvingMesh& evolving,
                    const std::filesystem::path& manifest, const std::string& about = "{}",
                    double uv_step = 0);

}  // namespace mq
