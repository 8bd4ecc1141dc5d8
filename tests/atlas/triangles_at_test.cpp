// Which triangle covers a place: what a look at every triangle says.
#include "mq/atlas/triangles_at.h"

#include <gtest/gtest.h>

#include "atlas/atlas_fixtures.h"
#include "mq/base/random.h"

namespace mq {
namespace {

/// The first triangle that covers a place.
int first_of_all(const fixtures::Textured& model, const TexelPoint& place) {
  for (int t = 0; t < model.surface.triangle_count(); ++t) {
    if (model.atlas.chart[std::size_t(t)] < 0) continue;
    const auto& [a, b, c] = model.atlas.corners[std::size_t(t)];
    const int turn = sign(orientation(a, b, c));
    if (turn != 0 && sign(orientation(a, b, place)) * turn >= 0 &&
        sign(orientation(b, c, place)) * turn >= 0 && sign(orientation(c, a, place)) * turn >= 0)
      return t;
  }
  return -1;
}

TEST(TrianglesAt, FindsTheFirstOfAllThatCoverAPlace) {
  fixtures::CutOptions cut;
  cut.angle = [](int chart) { return 0.3 * chart; };
  const auto model = fixtures::textured(fixtures::cut_square(cut), {{61, 53}});
  const TrianglesAt triangles(model->surface.mesh, model->atlas);
  const Random random(3);
  int covered = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const TexelPoint place{std::llround((random.uniform(2 * i) * 65 - 2) * double(TexelPoint::one)),
                           std::llround((random.uniform(2 * i + 1) * 57 - 2) * double(TexelPoint::one))};
    const auto found = triangles(0, place);
    ASSERT_EQ(found.triangle, first_of_all(*model, place));
    if (found.triangle < 0) continue;
    ++covered;
    Vector2 sum = Vector2::Zero();
    for (int k = 0; k < 3; ++k) {
      const TexelPoint& corner = model->atlas.corners[std::size_t(found.triangle)][std::size_t(k)];
      sum += found.barycentric[k] * Vector2(corner.column(), corner.row());
    }
    EXPECT_NEAR(sum.x(), place.column(), 1e-9);
    EXPECT_NEAR(sum.y(), place.row(), 1e-9);
  }
  EXPECT_GT(covered, 1000);
  EXPECT_LT(covered, 3500);
}

TEST(TrianglesAt, CountsBordersAndCornersAsCovered) {
  const auto model = fixtures::textured(fixtures::uv_on_texel_line(16), {{16, 16}});
  const TrianglesAt triangles(model->surface.mesh, model->atlas);
  for (int t = 0; t < model->surface.triangle_count(); ++t)
    for (const TexelPoint& corner : model->atlas.corners[std::size_t(t)]) {
      EXPECT_EQ(triangles(0, corner).triangle, first_of_all(*model, corner));
      EXPECT_GE(triangles(0, corner).triangle, 0);
    }
}

}  // namespace
}  // namespace mq
