#include "texture_set.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq::view {

int TextureSet::largest_side() {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  return most;
}

TextureSet::TextureSet(const std::vector<Texture>& textures, int largest) {
  for (const Texture& texture : textures) {
    const Image<float>& pixels = texture.pixels;
    if (pixels.width() > largest || pixels.height() > largest)
      throw Unsupported(fmt::format(
          "{}: is {} × {}, and this machine's graphics show at most {} a side: view a smaller copy",
          texture.path.string(), pixels.width(), pixels.height(), largest));
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
    held->unranged.assign(held->changed.size(), 1);
    held->ranges.resize(held->changed.size());
    textures_.push_back(std::move(held));
    show(size() - 1, pixels);
  }
}

TextureSet::Held::Held(const Held& other)
    : width(other.width),
      height(other.height),
      channels(other.channels),
      light(other.light),
      bytes(other.bytes),
      small(other.small),
      large(other.large),
      changed(other.changed.size(), 1),
      unranged(other.changed.size(), 1),
      ranges(other.ranges.size()) {}

TextureSet::TextureSet(const TextureSet& other) {
  for (const auto& held : other.textures_) textures_.push_back(std::make_unique<Held>(*held));
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

Image<float> TextureSet::image(int i) const {
  const Held& held = *textures_[std::size_t(i)];
  const int channels = std::min(held.channels, 4);
  Image<float> all(held.width, held.height, channels);
  parallel_for(
      held.height,
      [&](std::int64_t y) {
        for (int x = 0; x < held.width; ++x)
          for (int c = 0; c < channels; ++c)
            all(x, int(y), c) = held.get((std::size_t(y) * held.width + x) * 4 + std::size_t(c));
      },
      16);
  return all;
}

std::vector<float> TextureSet::texel(int i, int x, int y) const {
  const Held& held = *textures_[std::size_t(i)];
  std::vector<float> values;
  for (int c = 0; c < std::min(held.channels, 4); ++c)
    values.push_back(held.get((std::size_t(y) * held.width + x) * 4 + c));
  return values;
}

TextureSet::Held::Range TextureSet::Held::range_of(int number) const {
  Range range;
  range.low.fill(std::numeric_limits<float>::infinity());
  range.high.fill(-std::numeric_limits<float>::infinity());
  const int left = number % columns() * tile, top = number / columns() * tile;
  for (int y = top; y < std::min(top + tile, height); ++y)
    for (int x = left; x < std::min(left + tile, width); ++x)
      for (std::size_t c = 0; c < std::size_t(std::min(channels, 4)); ++c) {
        const float value = get((std::size_t(y) * width + x) * 4 + c);
        if (!std::isfinite(value)) continue;
        range.low[c] = std::min(range.low[c], value);
        range.high[c] = std::max(range.high[c], value);
      }
  return range;
}

std::array<float, 2> TextureSet::range(int channel) const {
  const auto held_still = lock();
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const auto& held : textures_) {
    if (channel >= std::min(held->channels, 4)) continue;
    parallel_for(std::ssize(held->unranged), [&](std::int64_t t) {
      if (std::exchange(held->unranged[std::size_t(t)], 0) != 0)
        held->ranges[std::size_t(t)] = held->range_of(int(t));
    });
    for (const Held::Range& range : held->ranges) {
      low = std::min(low, range.low[std::size_t(channel)]);
      high = std::max(high, range.high[std::size_t(channel)]);
    }
  }
  if (!(low <= high)) return {0, 1};
  return low < high ? std::array{low, high} : std::array{low - 0.5F, high + 0.5F};
}

std::int64_t TextureSet::upload(std::int64_t most) {
  changed_ = false;
  std::int64_t texels = 0;
  for (const auto& held : textures_) {
    if (!held->picture) {
      held->picture.emplace();
      held->picture->allocate(std::max(1, held->width), std::max(1, held->height),
                              held->bytes ? Picture::Kind::bytes : Picture::Kind::halves);
    }
    const int columns = held->columns();
    for (std::size_t t = 0; t < held->changed.size(); ++t) {
      if (texels >= most) return texels;
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
        held->picture->put(x, y, width, height, held->small.data() + first, held->width);
      else
        held->picture->put(x, y, width, height, held->large.data() + first, held->width);
      texels += std::int64_t(width) * height;
    }
  }
  return texels;
}

}  // namespace mq::view
