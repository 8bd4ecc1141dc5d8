#pragma once
/// Polygons of a file, cut into triangles.

#include <span>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Cuts the polygon with these corners, in order, into n − 2 triangles of its corners 0 to n − 1
/// with the polygon's orientation: a fan about corner 0 where all its triangles face the polygon's
/// side, ears (seen along the polygon's mean normal) where it is not convex. A polygon that crosses
/// itself or has no area is cut somehow; no triangle is lost. O(n) for a fan, O(n²) otherwise.
std::vector<Triangle> triangulate(std::span<const Vector3> corners);

/// Longest polygon that is cut where a fan does not do: O(n²) stays below a second.
inline constexpr int max_polygon = 10000;

}  // namespace mq
