#pragma once
/// The pictures of a model in less memory while something else needs it.

#include <vector>

#include "mq/image/packed_image.h"
#include "mq/io/model.h"

namespace mq {

/// For as long as this lives the model's textures have no pixels; then they have the same as before.
class PackedPictures {
 public:
  explicit PackedPictures(Model& model) : model_(model) {
    for (Texture& texture : model.textures) pictures_.emplace_back(std::move(texture.pixels));
  }
  ~PackedPictures() {
    for (std::size_t i = 0; i < pictures_.size(); ++i) model_.textures[i].pixels = std::move(pictures_[i]).unpacked();
  }
  PackedPictures(const PackedPictures&) = delete;
  PackedPictures& operator=(const PackedPictures&) = delete;

 private:
  Model& model_;
  std::vector<PackedImage> pictures_;
};

}  // namespace mq
