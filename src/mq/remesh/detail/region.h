#pragma once
/// The part of space in which a template is replaced: all that is nearer than a radius to where it
/// and its target do not fit.

#include <memory>
#include <vector>

#include "mq/mesh/closest_point.h"
#include "mq/remesh/detail/clip_surfaces.h"

namespace mq {

/// The distance to marked vertices of two surfaces, and to the edges and triangles between them.
/// It grows as more are marked: never up.
class MarkedRegion {
 public:
  /// `radius` in model units: distances are exact below twice that, others are at least so large.
  explicit MarkedRegion(double radius) : radius_(radius) {}

  double radius() const { return radius_; }

  /// Adds what is spanned by vertices (1 per vertex of the pair) of which at least one is `fresh`,
  /// and updates the distances of all vertices: to this it counts as `farther` than it is, model
  /// units, 0 to `radius`.
  void mark(const SurfacePair& pair, const std::vector<char>& marked,
            const std::vector<char>& fresh, double farther);

  /// Distances of vertices added since.
  void follow(const SurfacePair& pair);

  /// Per vertex of the pair, model units.
  const std::vector<double>& distances() const { return distances_; }

  /// The distance of any point, near or far; infinite where nothing is marked.
  double operator()(const Vector3& point) const;

 private:
  struct Piece {
    Mesh mesh;
    Vector3 low, high;  // of the box that lies 2·radius around
    std::unique_ptr<ClosestPointFinder> finder;
    double farther;
    double distance(const Vector3& point) const;
  };
  double radius_;
  std::vector<std::unique_ptr<Piece>> pieces_;
  std::vector<double> distances_;
};

/// Marks, from the seeds (score above 1) on, all neighbours with a score above `keep`, theirs and
/// so on. 1 per vertex.
std::vector<char> spread_seeds(const SurfacePair& pair, const std::vector<double>& scores,
                               double keep);

}  // namespace mq
