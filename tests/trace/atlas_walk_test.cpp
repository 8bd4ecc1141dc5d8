// Walks over the seams of an atlas: on a flat surface they are straight lines, however it is cut.

#include "mq/trace/atlas_walk.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "fem/cut_squares.h"

namespace mq {
namespace {

/// The map from the texels of a triangle's texture to the plane of a flat surface, and back where inverted.
struct TexelMap {
  TexelMap(const fixtures::Textured& model, int triangle) {
    const auto texel = [&](int k) {
      const TexelPoint& p = model.atlas.corners[std::size_t(triangle)][std::size_t(k)];
      return Vector2(p.column(), p.row());
    };
    const auto place = [&](int k) { return Vector2(model.surface.mesh.position(triangle, k).head<2>()); };
    Eigen::Matrix2d texels, places;
    texels << texel(1) - texel(0), texel(2) - texel(0);
    places << place(1) - place(0), place(2) - place(0);
    linear = places * texels.inverse();
    middle = (texel(0) + texel(1) + texel(2)) / 3;
    of_middle = (place(0) + place(1) + place(2)) / 3;
  }
  Vector2 operator()(const Vector2& texel) const { return of_middle + linear * (texel - middle); }

  Eigen::Matrix2d linear;
  Vector2 middle, of_middle;
};

TEST(AtlasWalk, IsAStraightLineOnAFlatSurface) {
  for (const auto& options : {fixtures::turned(fixtures::odd_angle, 3), fixtures::slanted(3)}) {
    const auto model = fixtures::textured(fixtures::cut_square(options), {{128, 128}});
    const AtlasWalk walk(model->surface, model->atlas);
    const Random random(2);
    int arrived = 0, over_seams = 0, ended = 0;
    for (int t = 0; t < model->surface.triangle_count(); ++t) {
      const TexelMap here(*model, t);
      const Vector2 way(random.uniform(std::uint64_t(2 * t), -25, 25),
                        random.uniform(std::uint64_t(2 * t + 1), -25, 25));
      const Vector2 expected = here(here.middle + way);
      const std::optional<AtlasPlace> end = walk({t, here.middle}, way);
      if (!end) {
        EXPECT_TRUE(expected.minCoeff() < 1e-9 || expected.maxCoeff() > 1 - 1e-9);
        ++ended;
        continue;
      }
      EXPECT_LT((TexelMap(*model, end->triangle)(end->texel) - expected).norm(), 1e-7);
      ++arrived;
      over_seams += model->atlas.chart[std::size_t(end->triangle)] != model->atlas.chart[std::size_t(t)];
    }
    EXPECT_GT(over_seams, 50);
    EXPECT_GT(arrived, ended);
    EXPECT_GT(ended, 10);
  }
}

}  // namespace
}  // namespace mq
