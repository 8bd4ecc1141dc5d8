#pragma once
/// The point of a mesh that moves that is closest to a given one.

#include <span>
#include <vector>

#include "mq/mesh/closest_point.h"

namespace mq {

/// The answers of `ClosestPointFinder`, bit for bit, for a mesh whose vertices move a little between questions and
/// whose triangles stay: what is set up, in O(n log n), follows them in O(n). It is as fast as a new one while
/// triangles that were near stay near. The mesh is referred to and must stay.
class MovingClosestPointFinder {
 public:
  /// Throws `InvalidInput` for a mesh without triangles or with positions that are not finite.
  explicit MovingClosestPointFinder(const Mesh& mesh);

  /// To be called once vertices have moved. Throws as above.
  void follow();

  /// For many points, in parallel; sooner where the triangle of a guess is near: closest points of before. They are
  /// not asked unless there are as many as points. Throws `InvalidInput` for a point that is not finite.
  std::vector<ClosestPoint> operator()(std::span<const Vector3> points, std::span<const ClosestPoint> guesses) const;

 private:
  /// A box around some of the triangles. The first of its halves comes next in the list.
  struct Node {
    Vector3 low, high;
    int begin = 0, end = 0;  ///< in `triangles_`
    int second = 0;          ///< the other half; 0: it has none
  };

  void divide(int begin, int end, const std::vector<Vector3>& middles);
  ClosestPoint closest(const Vector3& point, int guess) const;

  const Mesh& mesh_;
  std::vector<int> triangles_;
  std::vector<Node> nodes_;
  double farthest_ = 0;  ///< from the origin, of all coordinates
};

}  // namespace mq
