// A brush that changes the modulation: it ends where a solve from the start ends.

#include "mq/filter/live_modulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fem/cut_squares.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/filter/screened_poisson.h"

namespace mq {
namespace {

struct Painted {
  fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {160, 160});
  TexelSpace space{cut.model->surface, cut.model->atlas};
  double weight = std::pow(3 * space.scale().texel_spacing, 2);
  Signal psi = test::random_signal(space.size(), 3);

  /// Texels within `radius` of a place, and a modulation that is `strength` in the middle.
  std::vector<int> under(double x, double y, double radius) const {
    std::vector<int> texels;
    for (int k = 0; k < space.size(); ++k) {
      const auto& p = space.texels().positions[k];
      if (std::hypot(p[0] - x, p[1] - y) < radius) texels.push_back(k);
    }
    return texels;
  }
};

TEST(LiveModulation, EndsWhereASolveFromTheStartEnds) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi, {.reach = 4});
  for (const double x : {0.3, 0.4, 0.5, 0.6}) {
    const std::vector<int> texels = p.under(x, 0.5, 0.15);
    ASSERT_FALSE(texels.empty());
    live.modulate(texels, std::vector<double>(texels.size(), 3.0));
    live.follow();
  }
  const Signal exact =
      ScreenedPoisson(p.space, p.weight).solve(p.psi, live.beta()).signal;
  const double change = (exact - p.psi).cwiseAbs().maxCoeff();
  for (int i = 0; i < 4; ++i) live.follow();
  EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 0.02 * change);  // e^-4, the reach
  EXPECT_TRUE(live.settle({.tolerance = 1e-9}).converged);
  EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 1e-6 * change);
}

TEST(LiveModulation, EndsWhereASolveFromTheStartEndsAtVerticesToo) {
  const Surface sphere = make_surface(fixtures::sphere(6));
  const VertexSpace space(sphere);
  const double weight = 4 * space.scale().area / space.size();
  const Signal psi = test::random_signal(space.size(), 4);
  LiveModulation live(space, weight, psi, {.reach = 4});
  for (const double x : {-0.2, 0.0, 0.2}) {
    std::vector<int> painted;
    for (int v = 0; v < space.size(); ++v)
      if ((sphere.mesh.positions[std::size_t(v)] - Vector3(x, 0, 1)).norm() < 0.3)
        painted.push_back(v);
    ASSERT_GT(painted.size(), 100U);
    live.modulate(painted, std::vector<double>(painted.size(), 3.0));
    live.follow();
  }
  EXPECT_LT(live.followed().size(), std::size_t(space.size()) / 2);
  const Signal exact = ScreenedPoisson(space, weight).solve(psi, live.beta()).signal;
  const double change = (exact - psi).cwiseAbs().maxCoeff();
  for (int i = 0; i < 4; ++i) live.follow();
  EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 0.02 * change);
  EXPECT_TRUE(live.settle({.tolerance = 1e-9}).converged);
  EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 1e-6 * change);
}

TEST(LiveModulation, SaysWhichTexelsItChanged) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi);
  const std::vector<int> texels = p.under(0.5, 0.5, 0.1);
  live.modulate(texels, std::vector<double>(texels.size(), 3.0));
  live.follow();
  const std::span<const int> followed = live.followed();
  ASSERT_LT(followed.size(), std::size_t(p.space.size()));
  EXPECT_TRUE(std::ranges::is_sorted(followed));
  for (int k = 0; k < p.space.size(); ++k)
    if (!std::ranges::binary_search(followed, k)) {
      ASSERT_EQ((live.signal().row(k) - p.psi.row(k)).cwiseAbs().maxCoeff(), 0) << k;
    }
}

TEST(LiveModulation, SettlesInFewCyclesAtATimeToo) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi);
  const std::vector<int> texels = p.under(0.5, 0.5, 0.3);
  live.modulate(texels, std::vector<double>(texels.size(), 3.0));
  int rounds = 0;
  while (!live.settle({.tolerance = 1e-8, .max_cycles = 2}).converged) ASSERT_LT(++rounds, 40);
  EXPECT_GT(rounds, 0);
  // A residual that is small from the start is not taken for a small error, if that is asked for.
  EXPECT_EQ(live.settle({.tolerance = 1e-8}).cycles, 0);
  const SolveReport surely = live.settle({.tolerance = 1e-8, .least_cycles = 4});
  EXPECT_GE(surely.cycles, 4);
  EXPECT_TRUE(surely.converged);
  const Signal exact = ScreenedPoisson(p.space, p.weight).solve(p.psi, live.beta()).signal;
  const double change = (exact - p.psi).cwiseAbs().maxCoeff();
  EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 1e-5 * change);
}

TEST(LiveModulation, ReturnsWhenTheModulationIsTakenBack) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi, {.reach = 12});
  const std::vector<int> texels = p.under(0.5, 0.5, 0.1);
  live.modulate(texels, std::vector<double>(texels.size(), 0.0));
  live.follow({.error = 1e-6, .max_cycles = 20});
  EXPECT_GT((live.signal() - p.psi).cwiseAbs().maxCoeff(), 0.05);
  live.modulate(texels, std::vector<double>(texels.size(), 1.0));
  live.follow({.error = 1e-6, .max_cycles = 20});
  EXPECT_LT((live.signal() - p.psi).cwiseAbs().maxCoeff(), 2e-5);
}

TEST(LiveModulation, FollowsUntilNobodySeesWhatIsLeft) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi, {.reach = 12});
  for (const double x : {0.3, 0.4, 0.5, 0.6}) {
    const std::vector<int> texels = p.under(x, 0.5, 0.15);
    live.modulate(texels, std::vector<double>(texels.size(), 3.0));
    const Followed followed = live.follow({.error = 1e-3});
    EXPECT_LE(followed.error, 1e-3);
    EXPECT_LE(followed.cycles, 6);
    const Signal exact = ScreenedPoisson(p.space, p.weight).solve(p.psi, live.beta()).signal;
    EXPECT_LT((live.signal() - exact).cwiseAbs().maxCoeff(), 3e-3);
  }
}

TEST(LiveModulation, CostsWhatIsUnderTheBrush) {
  const auto updates = [](int side) {
    const fixtures::Cut cut =
        fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {side, side});
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const double spacing = space.scale().texel_spacing;
    LiveModulation live(space, 4 * spacing * spacing, test::random_signal(space.size(), 3));
    std::vector<int> texels;
    for (int k = 0; k < space.size(); ++k) {
      const auto& p = space.texels().positions[k];
      if (std::hypot(p[0] - 0.5, p[1] - 0.5) < 10 * spacing) texels.push_back(k);
    }
    live.modulate(texels, std::vector<double>(texels.size(), 3.0));
    return double(live.follow({.error = 0, .max_cycles = 1}).updates);
  };
  EXPECT_LT(updates(480), 1.1 * updates(160));  // of nine times as many texels
}

TEST(LiveModulation, LeavesTheSignalAloneBeforeTheFirstChange) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi);
  live.modulate({}, {});
  live.follow();
  EXPECT_EQ((live.signal() - p.psi).cwiseAbs().maxCoeff(), 0);
}

TEST(LiveModulation, RefusesWhatItCannotUse) {
  const Painted p;
  EXPECT_THROW(LiveModulation(p.space, 0, p.psi), InvalidInput);
  EXPECT_THROW(LiveModulation(p.space, std::numeric_limits<double>::infinity(), p.psi), InvalidInput);
  EXPECT_THROW(LiveModulation(p.space, p.weight, p.psi.topRows(3)), InvalidInput);
  LiveModulation live(p.space, p.weight, p.psi);
  EXPECT_THROW(live.modulate(std::vector<int>{p.space.size()}, std::vector<double>{2}), InvalidInput);
  EXPECT_THROW(live.modulate(std::vector<int>{0}, std::vector<double>{std::nan("")}), InvalidInput);
}

}  // namespace
}  // namespace mq
