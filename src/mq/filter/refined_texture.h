#pragma once
/// The triangles of a textured surface cut to the size of texels, for what runs on triangles.

#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"
#include "mq/mesh/refine.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// About how many vertices triangles cut so have where charts are large; up to half as many more
/// where they are scraps. Measured: docs/measurements/paths.md.
double expected_vertices(int texels, double longest_edge);

/// Surface, atlas and space must outlive it.
class RefinedTexture {
 public:
  /// Triangles in charts are cut until no edge is longer than `longest_edge` texels; those without a
  /// chart are left out. Throws as `refine` does.
  RefinedTexture(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                 double longest_edge, const Progress& progress = {});

  const RefinedSurface& fine() const { return fine_; }

  /// Where a point of a fine triangle is in space.
  Vector3 place(const SurfacePoint& point) const;

  /// A signal of texels at a point of a fine triangle, within the values it is made of.
  void value(const Signal& signal, const SurfacePoint& point, Eigen::Ref<Signal> row) const;

  /// The same at the vertices of the fine triangles.
  Signal at_vertices(const Signal& signal) const;

  /// Per texel where its centre lies on the fine triangles; for centres outside their chart the
  /// nearest point of the surface, which is across a seam where there is one.
  std::vector<SurfacePoint> starts(const Progress& progress = {}) const;

 private:
  Vector3 in_part(int t, const Vector3& point) const;
  SurfacePoint part_at(int first, const Vector3& point) const;
  void find_inside(std::vector<SurfacePoint>& starts) const;

  const Surface& source_;
  const Atlas& atlas_;
  const TexelSpace& space_;
  RefinedSurface fine_;
};

}  // namespace mq
