// What vertices of triangles cut to the size of texels see of a texture.
#include "mq/flow/detail/vertex_means.h"

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/fem/flat_triangle.h"

namespace mq {
namespace {

/// ∫ φ_v x dA / ∫ φ_v dA is (2·x_v + x_a + x_b)/4 in each triangle, by area; samples a texel apart come within a
/// tenth of a texel.
TEST(MeansAtVertices, OfPlacesAreThoseOfHatFunctions) {
  const fixtures::Cut cut = fixtures::cut("", fixtures::slanted(), {96, 96});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const RefinedTexture refined(cut.model->surface, cut.model->atlas, space, 7);
  Signal places(space.size(), 2);
  for (int i = 0; i < space.size(); ++i) places.row(i) = space.texels().position(i).head<2>().transpose();
  const Signal found = means_at_vertices(refined, places);

  const Surface& fine = refined.fine().surface;
  const std::vector<FlatTriangle> shapes = flat_triangles(fine);
  Signal sums = Signal::Zero(fine.mesh.vertex_count(), 3);
  for (int t = 0; t < fine.triangle_count(); ++t) {
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < 3; ++k) sum += fine.mesh.position(t, k);
    for (int k = 0; k < 3; ++k) {
      const Vector3 mean = (sum + fine.mesh.position(t, k)) / 4;
      const double area = shapes[std::size_t(t)].area();
      sums.row(fine.mesh.triangles[std::size_t(t)][k]) += area * Eigen::RowVector3d(mean.x(), mean.y(), 1);
    }
  }
  double worst = 0;
  for (int v = 0; v < fine.mesh.vertex_count(); ++v)
    worst = std::max(worst, (found.row(v) - sums.row(v).head<2>() / sums(v, 2)).norm());
  EXPECT_LT(worst, 0.1 * space.scale().texel_spacing);
}

}  // namespace
}  // namespace mq
