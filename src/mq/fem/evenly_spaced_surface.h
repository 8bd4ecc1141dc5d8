#pragma once
/// A surface in triangles of one size, for what has a scale of its own, whatever the model's triangles and texels are like.

#include <memory>
#include <span>

#include "mq/base/progress.h"
#include "mq/fem/vertex_space.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/coarsen.h"

namespace mq {

/// The surface with vertices about `spacing` apart: edges that are longer are halved, and vertices taken out where they lie
/// closer, as far as `coarsen` goes. Its topology is that of the surface; what lies between the vertices is cut off.
class EvenlySpacedSurface {
 public:
  /// Throws `InvalidInput` for a spacing that is not positive, and where there would be more than 2²⁷ triangles.
  EvenlySpacedSurface(const Surface& surface, double spacing, const Progress& progress = {});

  const VertexSpace& space() const { return *space_; }

  /// How many vertices there will be, about: those of a lattice of equilateral triangles.
  static double expected_size(const Surface& surface, double spacing);

  /// Values of a signal of `space()` at places on the surface: at the closest points of the surface, linear between
  /// what each vertex of the finer one, before any was taken out, has there. A row each.
  Signal at(std::span<const Vector3> places, const Signal& psi, const Progress& progress = {}) const;

 private:
  Surface fine_;  ///< edges halved, no vertex taken out
  CoarsenedSurface even_;
  std::unique_ptr<VertexSpace> space_;
  std::unique_ptr<ClosestPointFinder> closest_;  ///< of `fine_`
};

}  // namespace mq
