#include "mq/model/stored_atlas.h"

#include <fmt/format.h>

#include <vector>

#include "mq/base/error.h"

namespace mq {

EvolvingMesh read_frames(const EvolvingReader& reader) {
  EvolvingMesh evolving = reader.read();
  require(!evolving.frames.empty(), reader.manifest().string() + ": it holds no frame");
  return evolving;
}

LifespanAtlas lay_out_stored(const EvolvingReader& reader, EvolvingMesh& evolving,
                             const LifespanAtlasOptions& options, const Progress& progress) {
  try {
    return lay_out(evolving, options, progress);
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("{}: {}", reader.manifest().string(), error.what()));
  }
}

void write_laid_out(const EvolvingReader& reader, const EvolvingMesh& evolving,
                    const std::filesystem::path& manifest, const std::string& about, double uv_step) {
  std::vector<std::string> measured;
  for (const StoredFrame& frame : reader.frames()) measured.push_back(frame.measured);
  write_evolving(manifest, evolving, reader.step(), about, measured, uv_step, reader.group_frames());
}

}  // namespace mq
