#pragma once
/// The colours a model shows at its vertices.

#include "mq/io/model.h"
#include "mq/linear/matrix.h"

namespace mq {

/// A row per vertex of `model.mesh`: its colours if it has any (the first three channels), else the
/// mean of its textures as its corners see them, grey as three equal channels. Vertices that show
/// nothing get the mean of the others. Without any colours there are no columns.
Signal vertex_colours(const Model& model);

}  // namespace mq
