// Texels that stand for several places, and what pictures show of them.
#include "mq/fem/texel_copies.h"

#include <gtest/gtest.h>

#include <set>

#include "atlas/laid_strips.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

struct Copies {
  explicit Copies(const fixtures::StripOptions& options)
      : model(fixtures::textured(fixtures::laid_strip(options), {options.size})),
        apart(*separate_overlaps(model->surface, model->atlas)),
        space(model->surface, apart.atlas),
        copies(model->surface, apart, space) {}

  int chart(int unknown) const { return space.texels().chart[std::size_t(unknown)]; }

  std::unique_ptr<fixtures::Textured> model;
  SeparatedAtlas apart;
  TexelSpace space;
  TexelCopies copies;
};

/// Rows up to 20.3 belong to the first chart, rows from 20.8 on to the other; both read 20 and 21.
TEST(TexelCopies, ShowTheChartThatCoversTheCentre) {
  const Copies model(fixtures::two_halves(0.5));
  const std::vector<int> above = model.copies.meant({0, 20, 20}),
                         below = model.copies.meant({0, 20, 21});
  ASSERT_EQ(above.size(), 1U);
  ASSERT_EQ(below.size(), 1U);
  EXPECT_NE(model.chart(above[0]), model.chart(below[0]));
  std::set<int> rows;
  for (const Texels::Place& at : model.copies.shared()) rows.insert(at.y);
  EXPECT_EQ(rows, (std::set<int>{20, 21}));
  EXPECT_TRUE(model.copies.meant({0, 60, 60}).empty());

  Signal values(model.space.size(), 1);
  for (int i = 0; i < model.space.size(); ++i) values(i, 0) = 1 + model.chart(i);
  std::vector<Image<float>> pictures{Image<float>(64, 64, 1)};
  model.copies.scatter(values, pictures);
  EXPECT_EQ(pictures[0](20, 20), 1 + model.chart(above[0]));
  EXPECT_EQ(pictures[0](20, 21), 1 + model.chart(below[0]));
  EXPECT_EQ(pictures[0](20, 15), pictures[0](20, 20));
  EXPECT_EQ(pictures[0](60, 60), 0);
}

/// Charts on one another: both are meant, the one met first is shown.
TEST(TexelCopies, MeanEveryChartThatCoversTheCentre) {
  const Copies model(fixtures::two_halves(-10));
  const std::vector<int> both = model.copies.meant({0, 20, 15});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_LT(model.apart.atlas.charts[std::size_t(model.chart(both[0]))].turn,
            model.apart.atlas.charts[std::size_t(model.chart(both[1]))].turn);
}

/// As many as there are triangles that the centre lies in, of every triangle, the first too.
TEST(TexelCopies, MeanAsManyChartsAsCoverTheCentre) {
  const Copies model(fixtures::two_halves(-10));
  const Atlas& atlas = model.model->atlas;
  int looked_at = 0, of_first = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      int inside = 0;
      bool near_edge = false, first = false;
      for (int t = 0; t < model.model->surface.triangle_count(); ++t) {
        std::array<Vector2, 3> p;
        for (int k = 0; k < 3; ++k)
          p[std::size_t(k)] = Vector2(double(atlas.corners[t][k].x), double(atlas.corners[t][k].y)) / double(TexelPoint::one) -
                              Vector2(x, y);
        std::array<double, 3> side;
        for (std::size_t k = 0; k < 3; ++k) side[k] = cross(p[k], p[(k + 1) % 3]);
        const auto [least, most] = std::ranges::minmax(side);
        near_edge = near_edge || (least > -0.1 && most < 0.1) || std::ranges::any_of(side, [](double s) { return std::abs(s) < 1e-3; });
        if (least > 0 || most < 0) ++inside, first = first || t == 0;
      }
      if (near_edge || inside == 0) continue;
      EXPECT_EQ(model.copies.meant({0, x, y}).size(), std::size_t(inside)) << x << ' ' << y;
      ++looked_at;
      of_first += first && inside == 2;
    }
  EXPECT_GT(looked_at, 100);
  EXPECT_GT(of_first, 0);
}

/// Every unknown is a copy of the texel that its place on the surface had before.
TEST(TexelCopies, LieWhereTheirTexelDoes) {
  const Copies model(fixtures::around_twice());
  int twice = 0;
  for (int i = 0; i < model.space.size(); ++i) {
    const double x = model.space.texels().positions[std::size_t(i)][0];
    const int column = int(std::lround(4.2 + 40 * x - 0.2));
    EXPECT_EQ(model.copies.home(i).x, column % 40);
    twice += column >= 40;
  }
  EXPECT_GT(twice, 100);
}

}  // namespace
}  // namespace mq
