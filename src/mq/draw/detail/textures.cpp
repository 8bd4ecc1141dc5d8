#include "mq/draw/detail/textures.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

void check_textures(const Atlas& atlas, const std::vector<const Image<float>*>& textures) {
  if (textures.size() != atlas.textures.size())
    throw InvalidInput(fmt::format("{} pictures are given for an atlas of {} textures",
                                   textures.size(), atlas.textures.size()));
  for (std::size_t k = 0; k < textures.size(); ++k) {
    const TextureSize& size = atlas.textures[k];
    if (textures[k] == nullptr || textures[k]->empty())
      throw InvalidInput(fmt::format("texture {} has no pixels", k));
    if (textures[k]->width() != size.width || textures[k]->height() != size.height)
      throw InvalidInput(
          fmt::format("texture {} has {} x {} pixels, the atlas was made for {} x {}", k,
                      textures[k]->width(), textures[k]->height(), size.width, size.height));
  }
}

}  // namespace mq
