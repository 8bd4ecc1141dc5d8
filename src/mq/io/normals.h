#pragma once
/// Normals and tangents that a mesh file holds.

#include "mq/io/model.h"
#include "mq/mesh/tangent_frames.h"

namespace mq {

/// Whether the file a model came from says normals (vn of OBJ, nx of PLY, NORMAL of glTF). They are
/// not read, and come back as they were when the model is written, which is wrong once its shape
/// has changed.
bool holds_normals(const Model& model);

/// What the file a model came from says of shading: normals, and of glTF tangents, at the corners of
/// the model's triangles and in its axes; 0 where it says nothing (`tangent_frames` completes them).
/// A glTF primitive without NORMAL has those of its triangles, and no tangents. Tangents do not count
/// where a set of texture coordinates was chosen that the material does not name, or the material turns
/// them (KHR_texture_transform). Read anew from the file's bytes. Nothing where there is no file, or
/// its triangles are no longer the model's. Throws what `read_model` throws.
CornerFrames file_frames(const Model& model);

/// Forgets the file a model came from where it says normals, so that writing makes it anew and
/// without them: programs that read it compute their own. True where it did.
bool leave_out_normals(Model& model);

}  // namespace mq
