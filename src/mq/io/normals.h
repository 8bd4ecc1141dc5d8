#pragma once
/// Normals and tangents that a mesh file holds, and those that one made anew gets.

#include <filesystem>

#include "mq/io/model.h"
#include "mq/mesh/tangent_frames.h"

namespace mq {

/// Whether the file a model came from says normals (vn of OBJ, nx of PLY, NORMAL of glTF), or said
/// them
/// (`Model::shading`). Spliced, a file keeps them as they are.
bool holds_normals(const Model& model);

/// What the file a model came from says of shading: normals, and of glTF tangents, at the corners
/// of the model's triangles and in its axes; 0 where it says nothing (`tangent_frames` completes
/// them). A glTF primitive without NORMAL has those of its triangles, and no tangents. Tangents do
/// not count where a set of texture coordinates was chosen that the material does not name, or the
/// material turns them (KHR_texture_transform). Read anew from the file's bytes. Of a model without
/// a file what its `shading` is. Nothing where there is neither, or its triangles are no longer the
/// model's. Throws what `read_model` throws.
CornerFrames file_frames(const Model& model);

/// Forgets the file a model came from, so that writing makes it anew, but for what it says of
/// shading and of materials. Tangents are of its texture coordinates: forget them with these.
enum class Tangents { kept, forgotten };
void forget_file(Model& model, Tangents tangents);

/// Whether the material of one of a model's textures has a picture of normals, in a file of
/// `path`'s format that is made anew.
bool has_normal_map(const Model& model, int texture, const std::filesystem::path& path);

/// What such a file says of shading, all corners completed as `tangent_frames` does: normals where
/// the model's file says some (`holds_normals`); normals and tangents where it has a normal map,
/// which is expressed by them and would show another shape by a renderer's own. Else nothing.
CornerFrames frames_to_write(const Model& model, const std::filesystem::path& path);

}  // namespace mq
