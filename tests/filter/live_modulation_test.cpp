// A brush that changes the modulation: it ends where a solve from the start ends.

#include "mq/filter/live_modulation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

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

/// w·S_{β−1}·ψ − A·(φ − ψ) for the modulation of either solution.
Signal residual_of(const Painted& p, const LiveModulation& live, const std::vector<double>& texture) {
  std::vector<double> all, of_texture;
  for (std::size_t k = 0; k < texture.size(); ++k) {
    const double beta = live.beta()[k];
    all.push_back(beta - 1);
    of_texture.push_back((beta - 1) * (beta > 1 ? texture[k] : 1));
  }
  const SparseMatrix A = p.space.regularised_system(1, p.weight);
  Signal left(p.space.size(), 2 * p.psi.cols());
  left << p.weight * p.space.stiffness_times(p.psi, all) - A * Signal(live.signal().leftCols(p.psi.cols()) - p.psi),
      p.weight * p.space.stiffness_times(p.psi, of_texture) -
          A * Signal(live.signal().rightCols(p.psi.cols()) - p.psi);
  return left;
}

LiveOptions with_texture(const Painted& p) {
  LiveOptions options;
  for (int k = 0; k < p.space.size(); ++k) options.texture.push_back(k % 11 / 10.0);
  return options;
}

constexpr FollowOptions one_cycle{.error = 1e-4, .enough = 1};

TEST(LiveModulation, CarriesWhatACycleLeavesOver) {
  const Painted p;
  const LiveOptions options = with_texture(p);
  LiveModulation live(p.space, p.weight, p.psi, options);
  const double scale = p.weight * p.space.stiffness_times(p.psi).cwiseAbs().maxCoeff();
  for (const double x : {0.3, 0.4, 0.5, 0.6}) {
    const std::vector<int> texels = p.under(x, 0.5, 0.15);
    live.modulate(texels, std::vector<double>(texels.size(), x < 0.5 ? 3.0 : 0.2));
    const Followed followed = live.follow(one_cycle);
    EXPECT_EQ(followed.cycles, 1);
    EXPECT_GE(followed.unfinished, std::ssize(texels));
    EXPECT_GT(live.residual().cwiseAbs().maxCoeff(), 1e-4 * scale);
    EXPECT_LT((live.residual() - residual_of(p, live, options.texture)).cwiseAbs().maxCoeff(), 1e-11 * scale);
  }
}

TEST(LiveModulation, FinishesAtRestWhatACycleLeavesOver) {
  const Painted p;
  LiveOptions options = with_texture(p);
  options.reach = 12;  // so that what each touch leaves beyond it does not count
  LiveModulation moving(p.space, p.weight, p.psi, options), thorough(p.space, p.weight, p.psi, options);
  for (const double x : {0.2, 0.35, 0.5, 0.65, 0.8}) {
    const std::vector<int> texels = p.under(x, 0.5, 0.12);
    const std::vector<double> beta(texels.size(), 3.0);
    moving.modulate(texels, beta);
    moving.follow(one_cycle);
    thorough.modulate(texels, beta);
    thorough.follow({.error = 1e-4, .max_cycles = 20});
  }
  const auto apart = [&] { return (moving.signal() - thorough.signal()).cwiseAbs().maxCoeff(); };
  const double before = apart();
  EXPECT_GT(before, 2e-3);
  int times = 0;
  while (moving.follow(one_cycle).unfinished > 0) ASSERT_LT(++times, 20);
  EXPECT_GT(times, 1);
  EXPECT_LT(apart(), 1e-3);
  // All of it settles where the equation does, for both solutions.
  EXPECT_TRUE(moving.settle({.tolerance = 1e-9, .least_cycles = 4}).converged);
  const std::vector<double> all(moving.beta().begin(), moving.beta().end());
  std::vector<double> of_texture;
  for (std::size_t k = 0; k < all.size(); ++k)
    of_texture.push_back(1 + (all[k] - 1) * (all[k] > 1 ? options.texture[k] : 1));
  const ScreenedPoisson equation(p.space, p.weight);
  EXPECT_LT((moving.signal().leftCols(3) - equation.solve(p.psi, all).signal).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((moving.signal().rightCols(3) - equation.solve(p.psi, of_texture).signal).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(LiveModulation, GoesBackToWhereItLeftSomethingOver) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi);
  const std::vector<int> first = p.under(0.15, 0.15, 0.08), last = p.under(0.85, 0.85, 0.08);
  ASSERT_FALSE(first.empty());
  for (const std::vector<int>& texels : {first, last}) {
    live.modulate(texels, std::vector<double>(texels.size(), 3.0));
    live.follow(one_cycle);
  }
  EXPECT_FALSE(std::ranges::includes(live.followed(), first));
  std::int64_t left = live.follow(one_cycle).unfinished;
  EXPECT_TRUE(std::ranges::includes(live.followed(), last));  // where one looks, before anything else
  bool went_back = false;
  for (int times = 0; left > 0; ++times) {
    ASSERT_LT(times, 20);
    left = live.follow(one_cycle).unfinished;
    went_back |= std::ranges::includes(live.followed(), first);
  }
  EXPECT_TRUE(went_back);
}

TEST(LiveModulation, TakesNoTroubleOverWhatStaysAsItIs) {
  const Painted p;
  LiveModulation live(p.space, p.weight, p.psi);
  const std::vector<int> texels = p.under(0.3, 0.3, 0.1), others = p.under(0.7, 0.7, 0.05);
  live.modulate(texels, std::vector<double>(texels.size(), 3.0));
  while (live.follow().unfinished > 0) {}
  std::vector<int> both = texels;
  both.insert(both.end(), others.begin(), others.end());
  live.modulate(both, std::vector<double>(both.size(), 3.0));
  live.follow();
  EXPECT_FALSE(std::ranges::includes(live.followed(), texels));
  EXPECT_TRUE(std::ranges::includes(live.followed(), others));
}

TEST(LiveModulation, IsTheSameForAnyNumberOfThreads) {
  const Painted p;
  std::vector<Signal> found;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
    LiveModulation live(p.space, p.weight, p.psi, with_texture(p));
    for (const double x : {0.4, 0.6}) {
      const std::vector<int> texels = p.under(x, 0.5, 0.3);
      live.modulate(texels, std::vector<double>(texels.size(), 3.0));
      live.follow(one_cycle);
    }
    found.push_back(live.signal());
  }
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
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
