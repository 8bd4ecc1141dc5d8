#pragma once
/// Frames of a stored evolving mesh as models, and what its frames are all together.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/evolving_mesh.h"
#include "mq/image/image.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"

namespace mq {

/// Of the frames that a store can give.
struct StoreFigures {
  int triangles = 0;            ///< different ones, in all frames
  std::int64_t throughout = 0;  ///< of these, there in every frame
  double mean_lifespan = 0;     ///< frames
  std::int64_t bytes = 0;       ///< of all blocks, damaged ones too
};

/// `damaged` is what `EvolvingReader::damaged` says.
StoreFigures store_figures(const EvolvingReader& reader, const std::vector<int>& damaged);

/// What a model shows where vertices are in the first frame of a store, carried along by their ids.
class CarriedColours {
 public:
  /// Throws `InvalidInput` where the model has no colours, and
  /// where the store has no frame or it is not the first frame's own: where more than half of the
  /// vertices are farther than 2 % of its diagonal from it.
  CarriedColours(const Model& model, const EvolvingReader& reader);

  /// At the vertices of a segment; grey at those that were added later.
  VertexSignal at(const EvolvingSegment& segment) const;

 private:
  std::map<int, Eigen::RowVector3f> colours_;
};

/// How the frames of a store look.
struct StoredLook {
  const CarriedColours* colours = nullptr;              ///< at vertices; null: none
  std::function<Image<float>(int frame)> picture = {};  ///< of a frame (index), without pixels where it has none
};

/// Writes a model for each of the frames (indices), in metres where it is glTF; its picture is a PNG of its name, in
/// a
/// `.glb` within it. Throws
/// `InvalidInput` where there are not as many paths as frames or not that many frames in the store,
/// and `IoError` as reader and files do.
void write_stored_models(const EvolvingReader& reader, const std::vector<int>& frames,
                         const std::vector<std::filesystem::path>& paths, const StoredLook& look = {},
                         const Progress& progress = {});

}  // namespace mq
