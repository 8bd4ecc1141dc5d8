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

  /// Per unknown of `space()` the component of the surface (`triangle_components`) that it lies on.
  const std::vector<int>& components() const { return components_; }

  /// Places on the surface, and which component of it is meant where two lie on each other.
  struct Places {
    std::span<const Vector3> points;
    std::span<const int> components;  ///< as those of `triangle_components`; −1, or none: whatever is closest
  };

  /// Values of a signal of `space()` at places on the surface: at the closest points of the surface, linear between
  /// what each vertex of the finer one, before any was taken out, has there. A row each. Throws `InvalidInput` where the
  /// surface has no such component.
  Signal at(const Places& places, const Signal& psi, const Progress& progress = {}) const;

 private:
  ClosestPoint closest(const Places& places, std::size_t i) const;

  Surface fine_;                      ///< edges halved, no vertex taken out
  std::vector<int> fine_components_;  ///< per triangle of it
  bool is_connected_ = true;
  CoarsenedSurface even_;
  std::unique_ptr<VertexSpace> space_;
  std::vector<int> components_;  ///< per unknown of it
  std::unique_ptr<ClosestPointFinder> closest_;  ///< of `fine_`
};

}  // namespace mq
