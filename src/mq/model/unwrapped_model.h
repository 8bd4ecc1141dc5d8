#pragma once
/// A model with a new texture atlas.

#include <cstdint>

#include "mq/model/textured_model.h"
#include "mq/unwrap/unwrap.h"

namespace mq {

/// Forgets the texture coordinates that a model had, but for the numbers in its mesh, and the pictures that
/// lie by them. What its file says of materials and normals stays.
void forget_textures(Model& model);

/// Gives a model and its surface the texture coordinates that its surface was unwrapped with, and
/// one texture without a picture; nothing that belonged to the old ones stays, the atlas neither.
/// Normals that its file says stay.
void put_unwrapped(const Unwrapped& unwrapped, TexturedModel& model);

/// Of a model that was unwrapped for a texture of this size, the texels whose centres more than one
/// triangle covers, counted with `make_atlas` and `texel_coverage` as whoever reads the model finds
/// them.
std::int64_t overlapping_texels(const TexturedModel& model, TextureSize size,
                                const Progress& progress = {});

}  // namespace mq
