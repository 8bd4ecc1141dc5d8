#pragma once
/// A disc laid on a round one, whatever its shape.

#include <vector>

#include "mq/linear/direct.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Tutte's embedding [tutte1963draw]: the vertices of `loop`, a disc's only boundary in its order,
/// go evenly onto a circle that holds `area`, each other one to the mean of its neighbours, an edge
/// counting once per triangle. Nothing folds, up to rounding. One factorisation.
std::vector<Vector2> tutte_embedding(int vertex_count, const std::vector<Triangle>& triangles,
                                     const std::vector<int>& loop, double area,
                                     Factorisation kind = Factorisation::automatic);

}  // namespace mq
