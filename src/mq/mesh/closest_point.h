#pragma once
/// The point of a mesh that is closest to a given one.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"
#include "mq/mesh/surface_point.h"

namespace mq {

struct ClosestPoint : SurfacePoint {
  double squared_distance = 0;  ///< model units squared
};

/// The point of one triangle, which may be degenerate.
ClosestPoint closest_point(const Mesh& mesh, int triangle, const Vector3& point);

/// A prepared mesh. Embree's hierarchy (single precision, bounds rounded outward) proposes
/// triangles, distances are computed in double; the answer is that of comparing all triangles, the
/// lowest triangle where several are equally close. The mesh is referred to and must stay.
/// Set-up is O(n log n), a query O(log n) for points that are not many diameters away.
class ClosestPointFinder {
 public:
  /// Throws `InvalidInput` for a mesh without triangles or with positions that are not finite.
  explicit ClosestPointFinder(const Mesh& mesh);
  ~ClosestPointFinder();
  ClosestPointFinder(const ClosestPointFinder&) = delete;
  ClosestPointFinder& operator=(const ClosestPointFinder&) = delete;

  /// Any thread may ask. Throws `InvalidInput` for a point that is not finite.
  ClosestPoint operator()(const Vector3& point) const;

  /// The closest of those that `accept`s, no farther than `radius` (model units); triangle −1 where
  /// there is none. Of each triangle its closest point alone is offered, some of them, in any
  /// order.
  ClosestPoint among(const Vector3& point, double radius,
                     const std::function<bool(const ClosestPoint&)>& accept) const;

  /// For many points, in parallel.
  std::vector<ClosestPoint> operator()(std::span<const Vector3> points,
                                       const Progress& progress = {}) const;

  /// The same points, found sooner where the triangle of a guess is near: closest points of before, on
  /// this mesh or one like it. They are not asked unless there are as many as points, nor those whose
  /// triangle the mesh does not have.
  std::vector<ClosestPoint> operator()(std::span<const Vector3> points,
                                       std::span<const ClosestPoint> guesses) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace mq
