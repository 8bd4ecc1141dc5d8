#pragma once
/// What a model has to be drawn with, and how far its textures jump across seams.

#include <span>
#include <vector>

#include "mq/draw/render.h"
#include "mq/draw/seam_difference.h"
#include "mq/model/normal_axes.h"
#include "mq/model/textured_model.h"

namespace mq {

/// Whether every texture of the model has its picture.
bool has_pictures(const TexturedModel& model);

/// The pictures of textures, borrowed.
std::vector<const Image<float>*> pictures_of(std::span<const Texture> textures);

/// Three values per vertex of the surface, from the model's colours (grey is taken three times; of
/// copies of a vertex one counts); empty where it has none.
std::vector<float> surface_colours(const TexturedModel& model);

/// The texture, else colours at vertices, else clay.
RenderOptions::Paint best_paint(const TexturedModel& model);

/// A scale of colours for one channel of textures, over all the values there are.
FalseColour scale_of_textures(std::span<const Texture> textures, int channel,
                              FalseColour::Map map = FalseColour::Map::sequential);

/// `seam_difference` of the model's textures, or of others in their place, values as stored. The
/// model must have an atlas.
SeamDifference texture_seams(const TexturedModel& model, std::span<const Texture> textures);
SeamDifference texture_seams(const TexturedModel& model);

/// The same of normals in tangent space, seen in the model's axes and stored as such maps are,
/// (n + 1) / 2.
SeamDifference texture_seams(const TexturedModel& model, const ShadingFrames& frames);

}  // namespace mq
