#pragma once
/// Triangles cut into smaller ones, with no vertex left hanging on an edge.

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "mq/mesh/surface.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// The finer surface, and where its triangles lie in those they are parts of.
struct RefinedSurface {
  Surface surface;          ///< its mesh (positions and triangles only), twins, degenerate and area
  std::vector<int> source;  ///< per triangle the one it is a part of
  /// Per triangle the weights of the source's corners 1 and 2 at its three corners; exact, as they
  /// are sums of few powers of ½.
  std::vector<std::array<float, 6>> corners;

  /// A point of triangle t as weights of its source's corners.
  Vector3 in_source(int t, const Vector3& barycentric) const;
};

/// How long the line between two points of a triangle is, given by the weights of its corners 1
/// and 2.
using LineLength = std::function<double(int triangle, const Vector2& from, const Vector2& to)>;

/// Halves every edge that is longer than `most` as seen from either side, again and again until
/// none is: a triangle falls into two, three or four with each round. Only triangles that `keep`
/// says (1) remain; their order stays, parts of one after another. Throws `InvalidInput` when
/// `most` is not positive or more than 2²⁷ triangles would result.
RefinedSurface refine(const Surface& surface, std::span<const char> keep, const LineLength& length,
                      double most, const Progress& progress = {});

/// A mesh refined, with its texture coordinates.
struct RefinedMesh {
  Mesh mesh;
  std::vector<int> source;    ///< per triangle the one it is a part of
  std::vector<SurfacePoint> places;  ///< per vertex where it lies in the mesh that was refined
};

/// Halves the edges that are longer than `most` in space. Triangles that use a vertex twice, and
/// vertices of no triangle, are left out.
RefinedMesh refined(const Mesh& mesh, double most);

}  // namespace mq
