#pragma once
/// An evolving mesh of whatever file has one: a store, or a file that moves.

#include <filesystem>
#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/animation_read.h"
#include "mq/model/messages.h"

namespace mq {

struct EvolvingInput {
  EvolvingReader reader;
  std::optional<double> rate = {};          ///< frames a second, where the file says it: their mean
  std::optional<double> numbers_rate = {};  ///< numbers of frames a second, which `AnimationPart` wants
  std::vector<Image<float>> pictures = {};  ///< of each segment, as `OpenAnimation` has them
  std::vector<std::filesystem::path> files = {};  ///< that were read beside it: pictures, buffers

  /// Whether any segment has a picture; that of a frame (index), without pixels where it has none.
  bool has_pictures() const;
  const Image<float>& picture(int frame) const;
};

/// Opens `.usda`, `.usdz`, `.glb` and `.gltf` as `open_animation` does, anything else as a store; warns of what was
/// left out, and of what is broken, and remarks what else is worth knowing. Throws as these do, and `InvalidInput`
/// for a model or a folder.
EvolvingInput open_evolving(const std::filesystem::path& path, Messages& messages, const Progress& progress = {});

}  // namespace mq
