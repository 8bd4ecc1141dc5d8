#include "mq/model/lossless_textures.h"

#include <fmt/format.h>

namespace mq {

void replace_with_lossless(Model& model, std::vector<Image<float>> pictures,
                           const std::string& stem) {
  model.textures.resize(pictures.size());
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    Texture& texture = model.textures[k];
    const std::string own = texture.path.empty() ? texture.name : texture.path.stem().string();
    texture = Texture();
    texture.name = (own.empty() ? fmt::format("{}_{}", stem, k) : own) + ".png";
    texture.format.file_format = "png";
    texture.pixels = std::move(pictures[k]);
  }
}

}  // namespace mq
