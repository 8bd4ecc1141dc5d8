#pragma once
/// Where a surface that lies on another finds its own points on it.

#include <vector>

#include "mq/mesh/closest_point.h"

namespace mq {

struct FacingPointsOptions {
  double most_distance = 0.02;  ///< from the other surface, in its diagonals
  double most_angle = 60;       ///< between normals of both, degrees
};

/// A point p of the surface is the point q of the other (that which was captured, or a finer mesh)
/// closest to it among those that face the same way: normals, interpolated from vertices, differ by
/// no more than `most_angle`. So the inside of an arm is not taken for the body that it is near to.
/// And q must be its own: the point of the surface closest to q, facing the same way, is no nearer
/// than
///
///     |p' − q| ≥ (|p − q| − 2 a) / 2 ,
///
/// a the accuracy. Where the other surface has holes, and where parts of it have grown together,
/// the nearest of its points belongs to another place, which lies much closer to it: p has none
/// then.
class FacingPoints {
 public:
  /// Both meshes must stay. Throws `InvalidInput` for meshes without triangles and options out of
  /// range.
  FacingPoints(const Mesh& surface, const Mesh& other, const FacingPointsOptions& options = {});

  /// The other surface's point for a point of the surface; triangle −1: it has none. About 4 µs.
  ClosestPoint operator()(int triangle, const Vector3& barycentric) const;

  /// How well the surface lies on the other, in model units: the median distance of its vertices,
  /// or 1e-7 of the other's diagonal where that is more.
  double accuracy() const { return accuracy_; }

 private:
  /// A mesh, and what is asked of it.
  struct Side {
    explicit Side(const Mesh& of);
    Vector3 point(int triangle, const Vector3& barycentric) const;
    Vector3 normal(int triangle, const Vector3& barycentric) const;

    const Mesh& mesh;
    std::vector<Vector3> normals;  // of vertices
    ClosestPointFinder closest;
  };

  ClosestPoint facing(const Side& side, const Vector3& point, const Vector3& normal) const;

  Side surface_, other_;
  double radius_, least_cosine_, accuracy_ = 0;
};

}  // namespace mq
