#include "mq/model/value_space.h"

#include <algorithm>

#include "mq/image/normal_map.h"

namespace mq {

TransferFunction transfer(const Texture& texture) {
  const bool numbers = texture.meaning != TextureMeaning::colours;
  return numbers || holds_light(texture.format) ? TransferFunction::linear : TransferFunction::srgb;
}

std::optional<LightLaw> light_law(std::span<const Texture> textures, const ValueSpace& values) {
  if (values.meaning != ValueSpace::Meaning::colours || textures.empty() ||
      std::ranges::any_of(textures, [](const Texture& t) { return t.meaning != TextureMeaning::colours; }))
    return {};
  if (values.space == ColourSpace::log) return LightLaw::log;
  const bool is_display =
      values.space == ColourSpace::stored && transfer(textures.front()) == TransferFunction::srgb;
  return is_display ? LightLaw::display : LightLaw::linear;
}

Image<float> decoded(const Image<float>& stored, const Texture& texture, const ValueSpace& values) {
  if (values.meaning == ValueSpace::Meaning::normals) return normals_from_colours(stored);
  if (values.space == ColourSpace::stored) return stored;
  return decode(stored, values.space, transfer(texture));
}

Image<float> decoded(const Texture& texture, const ValueSpace& values) {
  return decoded(texture.pixels, texture, values);
}

Image<float> encoded(const Image<float>& worked, const Texture& texture, const ValueSpace& values) {
  if (values.meaning == ValueSpace::Meaning::normals) return colours_from_normals(worked);
  if (values.space == ColourSpace::stored) return worked;
  return encode(worked, values.space, transfer(texture));
}

std::int64_t put_changed(const Image<float>& before, const Image<float>& after,
                         const ValueSpace& values, Texture& texture) {
  std::int64_t changed = 0;
  const Image<float> stored = encoded(after, texture, values);
  for (int y = 0; y < before.height(); ++y)
    for (int x = 0; x < before.width(); ++x) {
      if (std::ranges::equal(before.pixel(x, y), after.pixel(x, y))) continue;
      ++changed;
      std::ranges::copy(stored.pixel(x, y), texture.pixels.pixel(x, y).begin());
    }
  return changed;
}

double value_step(const Texture& texture, const ValueSpace& values) {
  if (values.space != ColourSpace::stored) return 0;
  return texture.format.depth == Depth::u8    ? 1.0 / 255
         : texture.format.depth == Depth::u16 ? 1.0 / 65535
                                              : 0;
}

}  // namespace mq
