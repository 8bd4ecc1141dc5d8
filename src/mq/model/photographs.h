#pragma once
/// Photographs of a model: as textures of their own, of which `best_of` and `Stitcher` make one; and what
/// those with cameras say before they are read (photograph_texture.h makes a texture of them).

#include <span>
#include <string>
#include <vector>

#include "mq/draw/photograph.h"
#include "mq/filter/stitch.h"
#include "mq/io/cameras.h"
#include "mq/model/model_signal.h"

namespace mq {

/// A photograph given as textures, one for each texture of the model and of its size. `confidence`,
/// how well it shows each texel, is one picture for each of them, of any size (see
/// `mask_of_pictures`); empty: the alpha of the textures. Colours are taken as the model's textures
/// store them, display values or light, where the signal's values are those stored. Throws
/// `InvalidInput` naming the one that does not fit.
Partial partial_of_textures(const TexturedModel& model, const TextureSignal& signal,
                            std::vector<Texture> textures,
                            std::span<const Image<float>> confidence = {});

/// How all textures of the model store colours. Throws `InvalidInput` where they do not alike.
TransferFunction common_transfer(const Model& model);

/// What to say of a photograph whose camera was fitted to another size (`fitted_camera`); else nothing.
std::string remark_on_size(const Photograph& photograph, const PinholeCamera& fitted);

/// Whether more cameras would have most of the mesh in their pictures, and half of them at least, if it were turned by
/// 90 degrees about x: as where one is exported with y upright, the other with z.
bool axes_seem_exchanged(const Mesh& mesh, std::span<const PinholeCamera> cameras);

/// What to say then.
inline constexpr const char* exchanged_axes_hint =
    "turned by 90 degrees about x the mesh would be in the pictures: y is upright in one and z in the other: export "
    "both alike";

/// Gives a model's textures black pictures of the sizes that it was read with, where they have
/// none.
void add_missing_pictures(TexturedModel& model);

/// The side of a square texture, the nearest power of two from 256 to 8192, in which a texel is about as large as a
/// pixel of the photographs where these show the surface best: the median over the area
/// of the triangles, by the closest camera that faces each, whether or not something is in front. `occupancy`: the share of
/// the texture that charts will fill. 1024 where no camera faces any.
int side_for_photographs(const Surface& surface, std::span<const Photograph> photographs,
                         double occupancy = 0.7);

}  // namespace mq
