#pragma once
/// Primitives that Draco rounded each to a grid of its own.

#include "mq/io/detail/gltf_file.h"
#include "mq/io/detail/gltf_scene.h"

namespace mq {

struct GltfJoints {
  int moved = 0;        ///< vertices, those at one position counted once
  double farthest = 0;  ///< that one of them moved
};

/// Moves vertices at the border of a primitive onto those at the border of primitives before it, where
/// these lie within what rounding can have moved the two apart: half a step along each axis, for both.
/// A vertex of another primitive is taken by one only, so that no edge collapses. Nothing moves where
/// fewer than two primitives are there or none was rounded. Expected time linear.
GltfJoints join_grids(GltfScene& scene, const GltfFile& file);

}  // namespace mq
