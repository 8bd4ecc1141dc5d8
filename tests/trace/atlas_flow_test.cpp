// Paths in the texture itself: on a flat surface they are those of the plane, however it is cut into charts.

#include "mq/trace/atlas_flow.h"

#include <gtest/gtest.h>

#include <limits>

#include "fem/cut_squares.h"

namespace mq {
namespace {

struct Sheet {
  Sheet(const fixtures::CutOptions& options, int side)
      : options(options),
        model(fixtures::textured(fixtures::cut_square(options), {{side, side}})),
        space(model->surface, model->atlas),
        domain(model->surface, model->atlas, space),
        side(side) {}

  /// Where a place of a chart, or an unknown, is on the square or in the plane around it.
  Vector2 at(int chart, const Vector2& texel) const {
    return fixtures::on_square(options, chart, {(texel.x() + 0.5) / side, 1 - (texel.y() + 0.5) / side});
  }
  Vector2 at(const ChartPlace& place) const {
    const int stride = side + 2, column = place.cell % stride - 1, row = place.cell / stride - 1;
    return at(place.chart, Vector2(column + place.x, row + place.y));
  }
  Vector2 at(int unknown) const {
    const auto& texels = space.texels();
    return at(texels.chart[std::size_t(unknown)],
              Vector2(texels.places[std::size_t(unknown)].x, texels.places[std::size_t(unknown)].y));
  }
  template <class Function>
  Vector potential(const Function& function) const {
    Vector P(space.size());
    for (int i = 0; i < space.size(); ++i) P[i] = function(at(i));
    return P;
  }

  fixtures::CutOptions options;
  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TraceAtlas domain;
  int side;
};

TEST(AtlasFlow, IsAStraightLineOverTheSeamsOfAFlatSurface) {
  for (const auto& options : {fixtures::turned(fixtures::odd_angle, 3), fixtures::turned(fixtures::quarter_turn, 3),
                              fixtures::slanted(3), fixtures::turned([](int) { return 0.0; }, 1)}) {
    const Sheet sheet(options, 96);
    const Vector2 slope(0.31, -0.53);
    const AtlasFlow flow = AtlasFlow::downhill(
        sheet.domain, sheet.potential([&](const Vector2& p) { return slope.dot(p); }));
    const std::vector<ChartPlace> starts = sheet.domain.starts().places;
    const double time = 0.9;
    const TracedTexels traced = flow.trace(starts, time);
    EXPECT_EQ(traced.counts.cut_short, 0);
    int arrived = 0, over_seams = 0;
    double worst = 0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const Vector2 begin = sheet.at(starts[i]), expected = begin - time * slope;
      if (expected.minCoeff() < 0 || expected.maxCoeff() > 1) continue;
      worst = std::max(worst, (sheet.at(traced.ends[i]) - expected).norm());
      ++arrived;
      over_seams += traced.ends[i].chart != starts[i].chart;
    }
    EXPECT_GT(arrived, 700);
    if (options.parts > 1) EXPECT_GT(over_seams, 500);
    EXPECT_LT(worst, 1e-10);
  }
}

TEST(AtlasFlow, BearsEveryWayOfCutting) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const TraceAtlas domain(cut.model->surface, cut.model->atlas, space);
    const Vector3 slope(0.31, -0.53, 0);
    Vector P(space.size());
    for (int i = 0; i < P.size(); ++i) P[i] = slope.dot(space.texels().position(i));
    const AtlasFlow flow = AtlasFlow::downhill(domain, P);
    const std::vector<ChartPlace> starts = domain.starts().places;
    const std::int64_t cut_short = flow.trace(starts, std::numeric_limits<double>::infinity()).counts.cut_short;
    if (cut.apart) EXPECT_EQ(cut_short, 0) << cut.name;
    const double time = 0.3;
    const TracedTexels traced = flow.trace(starts, time);
    EXPECT_EQ(traced.counts.cut_short, 0) << cut.name;
    int arrived = 0, wrong = 0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const Vector3 begin = domain.position(starts[i]), expected = begin - time * slope;
      if (std::min(expected.x(), expected.y()) < 0 || std::max(expected.x(), expected.y()) > 1) continue;
      ++arrived;
      wrong += !((domain.position(traced.ends[i]) - expected).norm() < 0.1 * space.scale().texel_spacing);
    }
    EXPECT_GT(arrived, 0) << cut.name;
    // Of charts inside one cell nothing says where texels around them are.
    if (cut.apart && cut.size.width > 8) EXPECT_EQ(wrong, 0) << cut.name << ": of " << arrived;
  }
}

TEST(AtlasFlow, EndsAtTheCornerOfALinearPotential) {
  const Sheet sheet(fixtures::turned(fixtures::odd_angle, 3), 96);
  const AtlasFlow flow = AtlasFlow::downhill(
      sheet.domain, sheet.potential([](const Vector2& p) { return p.x() + 0.7 * p.y(); }));
  const TracedTexels traced = flow.trace(sheet.domain.starts().places, std::numeric_limits<double>::infinity());
  EXPECT_EQ(traced.counts.cut_short, 0);
  EXPECT_EQ(traced.counts.resting, std::ssize(traced.ends));
  for (const ChartPlace& end : traced.ends) EXPECT_LT(sheet.at(end).norm(), 1e-8);
}

TEST(AtlasFlow, ComesToRestAtTheMinimumOfABowl) {
  for (const auto& options : {fixtures::turned(fixtures::odd_angle, 3), fixtures::turned(fixtures::quarter_turn, 2)}) {
    const Sheet sheet(options, 96);
    const Vector2 lowest(0.47, 0.58);
    const AtlasFlow flow = AtlasFlow::downhill(
        sheet.domain, sheet.potential([&](const Vector2& p) { return (p - lowest).squaredNorm(); }));
    const TracedTexels traced = flow.trace(sheet.domain.starts().places, std::numeric_limits<double>::infinity());
    EXPECT_EQ(traced.counts.cut_short, 0);
    const double texel = 1 / std::sqrt(double(sheet.space.size()));
    double worst = 0;
    for (const ChartPlace& end : traced.ends) worst = std::max(worst, (sheet.at(end) - lowest).norm());
    EXPECT_LT(worst, 2 * texel);
  }
}

TEST(AtlasFlow, ComesBackWhereItBegan) {
  // Along a field that turns, there and back, over the seams of a torus; sliding is not undone.
  const auto model = fixtures::textured(fixtures::cut_torus(fixtures::turned(fixtures::odd_angle, 3)), {{160, 160}});
  const TexelSpace space(model->surface, model->atlas);
  const TraceAtlas domain(model->surface, model->atlas, space);
  Vector P(space.size());
  for (int i = 0; i < P.size(); ++i) P[i] = space.texels().position(i).z() + 0.3 * space.texels().position(i).x();
  const AtlasFlow down = AtlasFlow::downhill(domain, P), up = AtlasFlow::downhill(domain, -P);
  std::vector<ChartPlace> starts;
  for (const ChartPlace& node : domain.starts().places)  // inside a cell, and not near its edges
    if (!domain.bordered(node.cell) && domain.covered(node.cell)) starts.push_back({node.chart, node.cell, 0.3, 0.45});
  const double spacing = space.scale().texel_spacing;
  const TracedTexels there = down.trace(starts, 6 * spacing), back = up.trace(there.ends, 6 * spacing);
  int close = 0, moved = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    moved += (domain.position(there.ends[i]) - domain.position(starts[i])).norm() > 3 * spacing;
    close += back.ends[i].cell == starts[i].cell && std::abs(back.ends[i].x - starts[i].x) < 1e-9 &&
             std::abs(back.ends[i].y - starts[i].y) < 1e-9;
  }
  EXPECT_GT(moved, std::ssize(starts) / 2);
  EXPECT_GT(close, std::ssize(starts) * 8 / 10);
}

TEST(AtlasFlow, FollowsAFieldOverTexturesThatRepeat) {
  // One chart over the border of a texture that repeats: paths go on at its other side.
  fixtures::CutOptions options{.cells = 6, .parts = 1, .jitter = 0, .scale = 0.8};
  options.shift = [](int) { return Vector2(0.35, 0.2); };
  const Sheet sheet(options, 65);
  ASSERT_EQ(sheet.model->atlas.textures[0].wrap, Wrap::repeat);
  std::vector<std::array<double, 2>> right(std::size_t(sheet.domain.grid_cell_count()), {1.0, 0.25});
  const AtlasFlow flow = AtlasFlow::along(sheet.domain, right);
  std::vector<ChartPlace> starts;
  for (const ChartPlace& start : sheet.domain.starts().places)
    if (!sheet.domain.bordered(start.cell)) starts.push_back(start);
  const TracedTexels traced = flow.trace(starts, 7);
  const double texel = 1 / (0.8 * 65);
  int arrived = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Vector3 begin = sheet.domain.position(starts[i]), end = sheet.domain.position(traced.ends[i]);
    if (begin.x() + 8 * texel > 1 || begin.y() - 3 * texel < 0) continue;
    EXPECT_NEAR(end.x() - begin.x(), 7 * texel, 1e-5);
    EXPECT_NEAR(end.y() - begin.y(), -7 * 0.25 * texel, 1e-5);
    ++arrived;
  }
  EXPECT_GT(arrived, 1500);
}

}  // namespace
}  // namespace mq
