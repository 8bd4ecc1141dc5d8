#pragma once
/// In which values a signal is worked on, and how stored values come there and back.

#include <optional>
#include <span>

#include "mq/image/colour.h"
#include "mq/io/model.h"

namespace mq {

/// In which axes a normal map's vectors are.
enum class NormalAxes {
  as_found,     ///< in tangent space where the file's format or the values say so (normal_axes.h)
  object,       ///< the model's
  tangent,      ///< those of tangent_frames.h: green up, as glTF and OpenGL have it
  tangent_down  ///< the same with green down, as DirectX has it
};

struct ValueSpace {
  enum class Meaning { colours, normals } meaning = Meaning::colours;
  ColourSpace space = ColourSpace::stored;
  NormalAxes axes = NormalAxes::as_found;
};

/// Whether a texture stores display values or light; numbers that are no colours count as light.
TransferFunction transfer(const Texture& texture);

/// What values of these textures in the space are of light, as the first of them has it; nothing where they are
/// normals or other numbers.
std::optional<LightLaw> light_law(std::span<const Texture> textures, const ValueSpace& values);

/// Stored values of that texture in the space, and back, pixel by pixel.
Image<float> decoded(const Image<float>& stored, const Texture& texture, const ValueSpace& values);
Image<float> decoded(const Texture& texture, const ValueSpace& values);
Image<float> encoded(const Image<float>& worked, const Texture& texture, const ValueSpace& values);

/// Puts the pixels of `after` that are not those of `before`, both in the space, into the texture of
/// their size; returns how many there are. The others keep what is stored.
std::int64_t put_changed(const Image<float>& before, const Image<float>& after,
                         const ValueSpace& values, Texture& texture);

/// Between two neighbouring values of a texture of 8 or 16 bits in the space of stored values; 0 where
/// there is no one step.
double value_step(const Texture& texture, const ValueSpace& values);

}  // namespace mq
