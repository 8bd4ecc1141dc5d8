#pragma once
/// Triangle meshes of implicit surfaces.

#include <functional>

#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Negative inside, positive outside, about the distance near the surface.
using Solid = std::function<double(const Vector3&)>;

struct ImplicitOptions {
  Vector3 low{-1, -1, -1};  ///< a box around the solid, nowhere touching it
  Vector3 high{1, 1, 1};
  int triangles = 20000;         ///< about as many are made
  int euler_characteristic = 2;  ///< of the surface, to tell when the grid resolves it
  int relaxations = 12;          ///< rounds of evening out the triangles
};

/// The surface f = 0, oriented outward: one vertex in every grid cell that it crosses (Gibson,
/// Constrained elastic surface nets, 1998), then rounds in which vertices move to the mean of their
/// neighbours and back to the surface along the gradient. Closed, manifold and of the topology
/// stated; throws `InvalidInput` where that takes more triangles. No UVs.
Mesh mesh_of_solid(const Solid& solid, const ImplicitOptions& options,
                   const Progress& progress = {});

/// The union of two solids, rounded over a distance k where they meet.
double smooth_union(double a, double b, double k);

}  // namespace mq
