#include "mq/model/value_space.h"

#include "mq/image/normal_map.h"

namespace mq {

TransferFunction transfer(const Texture& texture) {
  return holds_light(texture.format) ? TransferFunction::linear : TransferFunction::srgb;
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

}  // namespace mq
