#pragma once
/// Normals that a mesh file holds.

#include "mq/io/model.h"

namespace mq {

/// Whether the file a model came from says normals (vn of OBJ, nx of PLY, NORMAL of glTF). They are
/// not read, and come back as they were when the model is written, which is wrong once its shape
/// has changed.
bool holds_normals(const Model& model);

/// Forgets the file a model came from where it says normals, so that writing makes it anew and
/// without them: programs that read it compute their own. True where it did.
bool leave_out_normals(Model& model);

}  // namespace mq
