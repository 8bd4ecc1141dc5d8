#pragma once
/// Vector fields as pictures that shaders read: flow maps, and what glTF calls an anisotropy texture.

#include "mq/model/model_field.h"

namespace mq {

/// Three columns per texel, as `KHR_materials_anisotropy` has them: (x + 1)/2 and (y + 1)/2 of the unit direction in
/// tangent space, x along growing u and y along growing v (up in the picture), at right angles to it; and the length of
/// the vector, which formats without floating point cut at 1. A vector of no length is (½, ½, 0). Of the field's texels where it has some, else
/// of its triangles. The signal must be one of texels, made of this model.
struct FieldMap {
  Signal values;
  std::int64_t beyond = 0;  ///< texels whose vector is longer than 1
};
FieldMap field_map(const TexturedModel& model, const ModelSignal& signal, const ModelField& field);

/// The pictures that such a name stands for, one per texture: with %s in it, or <UDIM>, as `Outputs` has them. Throws
/// `InvalidInput` where one picture is named for several textures.
std::vector<std::filesystem::path> map_files(const TexturedModel& model, const std::filesystem::path& file);

/// Such a picture as a field, two components per texel, and per triangle the mean of these. Where blue is black all over,
/// or there is none, red and green hold the vector itself, as flow maps have it. Of any size; a pixel less than 1/64
/// from grey, or black, where this would be longer than 1.2, has no vector. Throws `IoError` where it has fewer than two channels, and
/// `InvalidInput` where the signal has no texels, and what `map_files` throws.
ModelField field_of_map(const TexturedModel& model, const ModelSignal& signal, const std::filesystem::path& file);

}  // namespace mq
