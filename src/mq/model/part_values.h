#pragma once
/// Values of a part of a model's texels (texel_part.h), picture by picture: no picture needs to be held for longer than
/// its values are taken or put.

#include <span>
#include <vector>

#include "mq/fem/texel_part.h"
#include "mq/model/value_space.h"

namespace mq {

/// The part's own rows that lie in this texture of the model; `values` has a row per unknown of its space. Where the
/// picture lacks an alpha that the values have, that is 1. Throws `InvalidInput` where it has other channels or
/// another size, `IoError` where a value is not finite, naming the picture.
void take_values(const TexelPart& part, int texture, const TextureSize& size, const Texture& picture,
                 const ValueSpace& space, Signal& values);

/// Texels of one texture and what they become.
struct TexelValues {
  std::vector<Texels::Place> places;
  Signal values;  ///< a row each
};

/// The part's own texels of this texture that changed.
TexelValues changed_values(const TexelPart& part, int texture, const Signal& before, const Signal& after);

/// Puts them into the picture; the other texels keep what is stored.
void put_values(const TexelValues& changed, const ValueSpace& space, Texture& picture);

}  // namespace mq
