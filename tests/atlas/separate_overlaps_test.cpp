// Charts that share texels, laid apart; and charts cut where they share texels with themselves.
#include "mq/atlas/separate_overlaps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "atlas/laid_strips.h"
#include "mq/atlas/detail/injective_parts.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::unique_ptr<fixtures::Textured> laid(const fixtures::StripOptions& options,
                                         const AtlasOptions& wanted = {}) {
  return fixtures::textured(fixtures::laid_strip(options), {options.size}, wanted);
}

int parts_of(const Surface& surface, const Atlas& atlas) {
  return find_injective_parts(surface, atlas, Footprints(atlas)).count();
}

/// What must hold of every atlas that was laid apart.
void expect_apart(const fixtures::Textured& model, const SeparatedAtlas& apart) {
  // No texel is read by two charts, and no chart reads outside its picture.
  std::map<std::array<int, 3>, int> readers;
  const Footprints before(model.atlas), after(apart.atlas);
  for (int t = 0; t < model.surface.triangle_count(); ++t) {
    const int texture = model.surface.mesh.texture(t);
    const TextureSize &size = apart.atlas.textures[std::size_t(texture)],
                      &picture = apart.pictures[std::size_t(texture)];
    ASSERT_EQ(before.of(t).size(), after.of(t).size());
    for (std::size_t k = 0; k < after.of(t).size(); ++k) {
      const TexelSpan &was = before.of(t)[k], &is = after.of(t)[k];
      ASSERT_EQ(was.end - was.first, is.end - is.first);
      for (int i = 0; i < is.end - is.first; ++i) {
        const std::array<int, 3> texel = {texture, is.first + i, is.row};
        ASSERT_GE(texel[1], 0);
        ASSERT_GE(texel[2], 0);
        ASSERT_LT(texel[1], size.width);
        ASSERT_LT(texel[2], size.height);
        const int chart = apart.atlas.chart[std::size_t(t)];
        EXPECT_EQ(readers.try_emplace(texel, chart).first->second, chart);
        // It is a copy of the one that was read before.
        const SeparatedAtlas::Home home = apart.home(texture, texel[1], texel[2]);
        const int x = was.first + i, y = was.row;
        const bool repeats = picture.wrap == Wrap::repeat;
        EXPECT_EQ(home.x, repeats ? (x + 100 * picture.width) % picture.width
                                  : std::clamp(x, 0, picture.width - 1));
        EXPECT_EQ(home.y, repeats ? (y + 100 * picture.height) % picture.height
                                  : std::clamp(y, 0, picture.height - 1));
      }
    }
  }
  // And no texel stands for two places of one chart.
  EXPECT_EQ(parts_of(model.surface, apart.atlas), int(apart.atlas.charts.size()));
  EXPECT_FALSE(separate_overlaps(model.surface, apart.atlas));
  double texels = 0, area = 0;
  for (const Chart& chart : apart.atlas.charts)
    texels += chart.texel_area, area += chart.surface_area;
  EXPECT_NEAR(texels, model.atlas.texel_area, 1e-9 * texels);
  EXPECT_NEAR(area, model.atlas.surface_area, 1e-9 * area);
}

TEST(LayApart, DoesNothingWhereEveryTexelStandsForOnePlace) {
  const auto quad = fixtures::textured(fixtures::two_chart_quad(), {{40, 40}});
  EXPECT_FALSE(separate_overlaps(quad->surface, quad->atlas));
  // Rows up to 20 (cells up to 20.3) and from 23 on: nothing between them is read twice.
  const auto halves = laid(fixtures::two_halves(3));
  EXPECT_FALSE(separate_overlaps(halves->surface, halves->atlas));
  const auto bent = laid(fixtures::bent_back(4));
  EXPECT_FALSE(separate_overlaps(bent->surface, bent->atlas));
  // Around the border of a texture that repeats, but not over itself.
  fixtures::StripOptions around = fixtures::around_twice();
  around.size.width = 100;
  around.place = [](int, const Vector2& p) { return Vector2(40 * p.x() - 7.7, 20.3 - 40 * p.y()); };
  const auto model = laid(around);
  EXPECT_EQ(model->atlas.textures[0].wrap, Wrap::repeat);
  EXPECT_FALSE(separate_overlaps(model->surface, model->atlas));
}

/// On texel lines: one chart ends on a line, the next begins on the line after.
TEST(LayApart, LeavesChartsThatReadNeighbouringTexels) {
  fixtures::StripOptions options = fixtures::two_halves(0);
  const auto at = [](double gap) {
    return [gap](int piece, const Vector2& p) {
      return piece == 0 ? Vector2(4 + 40 * p.x(), 20 - 40 * p.y())
                        : Vector2(4 + 40 * (p.x() - 1), 30 + gap - 40 * p.y());
    };
  };
  options.place = at(1);
  const auto neighbours = laid(options);
  EXPECT_FALSE(separate_overlaps(neighbours->surface, neighbours->atlas));
  options.place = at(0);
  const auto touching = laid(options);
  EXPECT_TRUE(separate_overlaps(touching->surface, touching->atlas));
}

TEST(LayApart, MovesOneOfTwoChartsThatShareTexels) {
  for (const double gap : {0.5, 1.2, -5.0, -10.0}) {  // the last lie on one another
    const auto model = laid(fixtures::two_halves(gap));
    const auto apart = separate_overlaps(model->surface, model->atlas);
    ASSERT_TRUE(apart) << gap;
    expect_apart(*model, *apart);
    EXPECT_EQ(apart->atlas.charts.size(), 2U);
    EXPECT_EQ(apart->atlas.seam_count, model->atlas.seam_count);
    EXPECT_EQ(apart->atlas.textures[0].width, 64);
    EXPECT_LE(apart->atlas.textures[0].height, 64 + 11 + 5);
  }
}

TEST(LayApart, CutsAChartThatSharesTexelsWithItself) {
  const auto model = laid(fixtures::bent_back(0.6));
  ASSERT_EQ(model->atlas.charts.size(), 1U);
  const auto apart = separate_overlaps(model->surface, model->atlas);
  ASSERT_TRUE(apart);
  expect_apart(*model, *apart);
  EXPECT_GT(apart->atlas.charts.size(), 1U);
  EXPECT_GT(apart->atlas.seam_count, 0);
}

TEST(LayApart, UnrollsWhatRunsOverARepeatingTextureTwice) {
  const auto model = laid(fixtures::around_twice());
  const auto apart = separate_overlaps(model->surface, model->atlas);
  ASSERT_TRUE(apart);
  expect_apart(*model, *apart);
  EXPECT_EQ(apart->atlas.charts.size(), 1U);
  EXPECT_GE(apart->atlas.textures[0].width, 82);
}

TEST(LayApart, UnrollsWhatLeavesATextureThatDoesNotRepeat) {
  fixtures::StripOptions options = fixtures::around_twice();
  options.size.wrap = Wrap::clamp;
  const auto model = laid(options);
  const auto apart = separate_overlaps(model->surface, model->atlas);
  ASSERT_TRUE(apart);
  expect_apart(*model, *apart);
  EXPECT_FALSE(
      apart->home(0, apart->atlas.textures[0].width - 2, apart->shelves.front().y + 4).inside);
}

TEST(LayApart, CutsOutFoldsThatLieOnThemselves) {
  fixtures::StripOptions options = fixtures::two_halves(20);
  options.piece = [](const Vector2&) { return 0; };
  options.place = [](int, const Vector2& p) {  // back over itself from x = 1 on
    return Vector2(4.2 + 40 * (p.x() < 1 ? p.x() : 2 - p.x()), 20.3 - 40 * p.y());
  };
  const auto model = laid(options, {.flipped = AtlasOptions::Flipped::keep});
  ASSERT_EQ(model->atlas.charts.size(), 1U);
  const auto apart = separate_overlaps(model->surface, model->atlas);
  ASSERT_TRUE(apart);
  expect_apart(*model, *apart);
  EXPECT_EQ(apart->atlas.charts.size(), 2U);
}

TEST(LayApart, KeepsEachTextureItsOwn) {
  Mesh mesh = fixtures::laid_strip(fixtures::two_halves(0.5));
  mesh.textures.assign(std::size_t(mesh.triangle_count()), 0);
  const auto quarters = [&](int t) {
    return mesh.position(t, 1).x() > 0.5 && mesh.position(t, 1).x() <= 1.5;
  };
  for (int t = 0; t < mesh.triangle_count(); ++t)
    mesh.textures[std::size_t(t)] = quarters(t) ? 1 : 0;
  const auto model = fixtures::textured(mesh, {{64, 64}, {64, 80}});
  const auto apart = separate_overlaps(model->surface, model->atlas);
  ASSERT_TRUE(apart);
  expect_apart(*model, *apart);
}

/// Every way to cut a square: crowded charts below a texel among them.
TEST(LayApart, LaysAnyAtlasApart) {
  for (const int size : {5, 8, 24, 48})
    for (const int parts : {1, 2, 6}) {
      fixtures::CutOptions options;
      options.parts = parts;
      options.angle = fixtures::odd_angle;
      options.scale = 0.6;
      const auto model = fixtures::textured(fixtures::cut_square(options), {{size, size + 3}});
      if (const auto apart = separate_overlaps(model->surface, model->atlas))
        expect_apart(*model, *apart);
    }
}

TEST(LayApart, RefusesAFloorTiledAHundredTimes) {
  Mesh mesh = fixtures::flat_square(2);
  for (Vector2& uv : mesh.uvs) uv *= 90;
  const auto model = fixtures::textured(mesh, {{2048, 2048, Wrap::repeat}});
  EXPECT_THAT([&] { separate_overlaps(model->surface, model->atlas); },
              ThrowsMessage<Unsupported>(HasSubstr("unwrap it without overlaps")));
}

}  // namespace
}  // namespace mq
