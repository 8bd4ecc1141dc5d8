#include "texture_set.h"

#include <fmt/format.h>

#include <limits>

#include "mq/base/error.h"

namespace mq::view {

TextureSet::TextureSet(const std::vector<Texture>& textures) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  for (const Texture& texture : textures) {
    const Image<float>& pixels = texture.pixels;
    if (pixels.width() > most || pixels.height() > most)
      throw Unsupported(fmt::format(
          "{}: is {} × {}, and this machine's graphics show at most {} a side: view a smaller copy",
          texture.path.string(), pixels.width(), pixels.height(), most));
    auto held = std::make_unique<Held>();
    held->width = pixels.width(), held->height = pixels.height(),
    held->channels = pixels.channels();
    held->light = mq::holds_light(texture.format);
    held->bytes = texture.format.depth == Depth::u8;
    const std::size_t values = std::size_t(pixels.pixel_count()) * 4;
    if (held->bytes)
      held->small.assign(values, 255);
    else
      held->large.assign(values, 1.F);
    held->changed.assign(
        std::size_t(held->columns()) * std::size_t((pixels.height() + tile - 1) / tile), 1);
    held->picture.allocate(std::max(1, pixels.width()), std::max(1, pixels.height()),
                           held->bytes ? Picture::Kind::bytes : Picture::Kind::halves);
    textures_.push_back(std::move(held));
    show(size() - 1, pixels);
  }
}

void TextureSet::show(int i, const Image<float>& pixels) {
  Held& held = *textures_[std::size_t(i)];
  require(pixels.width() == held.width && pixels.height() == held.height &&
              pixels.channels() == held.channels,
          fmt::format(
              "a picture of {} × {} with {} channels is shown for texture {}, which has {} × {} "
              "with {}",
              pixels.width(), pixels.height(), pixels.channels(), i, held.width, held.height,
              held.channels));
  parallel_for(
      held.height,
      [&](std::int64_t y) {
        for (int x = 0; x < held.width; ++x) {
          bool differs = false;
          for (int c = 0; c < std::min(held.channels, 4); ++c)
            differs |= held.put((std::size_t(y) * held.width + x) * 4 + c, pixels(x, int(y), c));
          if (differs) held.mark(x, int(y));
        }
      },
      16);
}

std::vector<float> TextureSet::texel(int i, int x, int y) const {
  const Held& held = *textures_[std::size_t(i)];
  std::vector<float> values;
  for (int c = 0; c < std::min(held.channels, 4); ++c)
    values.push_back(held.get((std::size_t(y) * held.width + x) * 4 + c));
  return values;
}

std::array<float, 2> TextureSet::range(int channel) const {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const auto& held : textures_) {
    if (channel >= std::min(held->channels, 4)) continue;
    const std::size_t count = std::size_t(held->width) * held->height;
    for (std::size_t k = 0; k < count; ++k) {
      const float value = held->get(4 * k + channel);
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    }
  }
  if (!(low <= high)) return {0, 1};
  return low < high ? std::array{low, high} : std::array{low - 0.5F, high + 0.5F};
}

std::int64_t TextureSet::upload() {
  std::int64_t texels = 0;
  for (const auto& held : textures_) {
    const int columns = held->columns();
    for (std::size_t t = 0; t < held->changed.size(); ++t) {
      if (held->changed[t] == 0) continue;
      held->changed[t] = 0;
      const int x = int(t) % columns * tile, y = int(t) / columns * tile;
      int width = std::min(tile, held->width - x);
      const int height = std::min(tile, held->height - y);
      // Tiles beside it that changed too go along.
      for (; t + 1 < held->changed.size() && int(t + 1) % columns != 0 && held->changed[t + 1] != 0;
           ++t) {
        held->changed[t + 1] = 0;
        width = std::min(width + tile, held->width - x);
      }
      const std::size_t first = (std::size_t(y) * held->width + x) * 4;
      if (held->bytes)
        held->picture.put(x, y, width, height, held->small.data() + first, held->width);
      else
        held->picture.put(x, y, width, height, held->large.data() + first, held->width);
      texels += std::int64_t(width) * height;
    }
  }
  return texels;
}

}  // namespace mq::view
