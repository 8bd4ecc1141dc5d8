// Texels that stand for several places, and what pictures show of them.
#include "mq/fem/texel_copies.h"

#include <gtest/gtest.h>

#include <set>

#include "atlas/laid_strips.h"

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
