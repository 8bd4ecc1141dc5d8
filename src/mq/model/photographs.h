#pragma once
/// What photographs show of a model, as values of its texture signal: given as textures of their
/// own, or as pictures with their cameras. `best_of` and `Stitcher` make one texture of them.

#include <cstdint>
#include <optional>
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

/// Photographs with their cameras, read and projected onto the model one by one. Grey ones are
/// spread over three channels, and where the signal has alpha it is 1. Remarks on pictures of
/// another size than their camera's, and warns of those that show nothing. Throws `InvalidInput`
/// for pictures that do not fit their camera or the model's channels, and where the signal's values
/// are those stored and textures of the model do not store colours alike; and what `read_texture`
/// throws.
std::vector<Partial> partials_of_photographs(const TexturedModel& model,
                                             const TextureSignal& signal,
                                             std::span<const Photograph> photographs,
                                             const PhotographOptions& options, Messages& messages,
                                             const Progress& progress = {});

/// How all textures of the model store colours. Throws `InvalidInput` where they do not alike.
TransferFunction common_transfer(const Model& model);

/// How many unknowns it shows.
std::int64_t shown_unknowns(const Partial& partial);

/// What to say of a photograph whose camera was fitted to another size (`fitted_camera`); else nothing.
std::string remark_on_size(const Photograph& photograph, const PinholeCamera& fitted);

/// Gives a model's textures black pictures of the sizes that it was read with, where they have
/// none.
void add_missing_pictures(TexturedModel& model);

}  // namespace mq
