// The sweeps that spread heat and fronts: against a factorisation where its numbers last, and against
// the closed form where they do not.
#include "mq/filter/heat_sweeps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "filter/geodesic_squares.h"
#include "mq/filter/fast_marching.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

using fixtures::CutOptions;
using fixtures::four_charts;
using fixtures::nearest;
using fixtures::places_of;
using fixtures::whole_square;

TEST(FrontDistances, AreRightToAFewPerCent) {
  for (const CutOptions& options : {whole_square(), four_charts(), fixtures::slanted()}) {
    const auto model = fixtures::textured(fixtures::cut_square(options), {{160, 160}});
    const TexelSpace space(model->surface, model->atlas);
    const std::vector<Vector3> places = places_of(space);
    const int source = nearest(space.texels(), {0.31, 0.42, 0});
    const Vector w = fast_marching_distances(space.stiffness(), places, {{source, 0}});
    double sum = 0;
    for (int i = 0; i < space.size(); ++i) {
      const double d = (places[i] - places[source]).norm();
      EXPECT_GE(w[i], d * (1 - 1e-6));
      if (i != source) sum += w[i] / d - 1;
    }
    EXPECT_LE(sum / space.size(), 0.04);
  }
}

TEST(FrontDistances, AreExactForAPlaneFront) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  std::vector<std::pair<int, double>> edge;
  for (int i = 0; i < space.size(); ++i)
    if (space.texels().places[i].x == 0) edge.emplace_back(i, 0.5);
  const Vector w = fast_marching_distances(space.stiffness(), places_of(space), edge);
  for (int i = 0; i < space.size(); ++i)
    EXPECT_NEAR(w[i], 0.5 + space.texels().places[i].x / 64.0, 1e-6);
}

/// The distances end where nothing changes any more, whichever way unknowns are numbered.
TEST(FrontDistances, DoNotDependOnTheOrder) {
  for (const CutOptions& options : {four_charts(), fixtures::slanted()}) {
    const auto model = fixtures::textured(fixtures::cut_square(options), {{96, 96}});
    const TexelSpace space(model->surface, model->atlas);
    const SparseMatrix S = space.stiffness();
    const std::vector<Vector3> places = places_of(space);
    const std::vector<int> sources = {nearest(space.texels(), {0.31, 0.42, 0}), nearest(space.texels(), {0.9, 0.8, 0})};
    const Vector w = fast_marching_distances(S, places, {{sources[0], 0}, {sources[1], 0.05}});

    std::vector<int> number(std::size_t(space.size()));
    std::iota(number.begin(), number.end(), 0);
    std::ranges::shuffle(number, std::mt19937(7));
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < space.size(); ++i)
      for (SparseMatrix::InnerIterator it(S, i); it; ++it)
        entries.emplace_back(number[std::size_t(i)], number[std::size_t(it.col())], it.value());
    SparseMatrix shuffled(space.size(), space.size());
    shuffled.setFromTriplets(entries.begin(), entries.end());
    std::vector<Vector3> there(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) there[std::size_t(number[i])] = places[i];
    const Vector again = fast_marching_distances(
        shuffled, there, {{number[std::size_t(sources[0])], 0}, {number[std::size_t(sources[1])], 0.05}});
    double largest = 0;
    for (int i = 0; i < space.size(); ++i) largest = std::max(largest, std::abs(again[number[std::size_t(i)]] - w[i]));
    EXPECT_LE(largest, 1e-9);
  }
}

/// How many of the unknowns differ by more than `far` from the factorisation's log u.
double share_beyond(double far, const CutOptions& options, int side) {
  const auto model = fixtures::textured(fixtures::cut_square(options), {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const double t = 4 * space.scale().texel_spacing * space.scale().texel_spacing;
  SparseMatrix A = space.regularised_system(0, t);
  A.diagonal() += space.mass() * Vector::Ones(space.size());
  Vector b = Vector::Zero(space.size());
  b[40] = 1;
  const Vector u = DirectSolver(A).solve(b);
  const HeatSweeps heat = sweep_heat(A, {{40, 0}}, {.tolerance = 1e-7, .max_sweeps = 100});
  EXPECT_LE(heat.change, 1e-7);
  int beyond = 0;
  for (int i = 0; i < space.size(); ++i)
    beyond += !(std::abs(heat.log_u[i] - std::log(u[i] / u[40])) <= far);
  return double(beyond) / space.size();
}

TEST(HeatSweeps, AgreeWithAFactorisationWhereItsNumbersLast) {
  EXPECT_EQ(share_beyond(1e-4, whole_square(), 96), 0);
  EXPECT_EQ(share_beyond(1e-4, four_charts(), 96), 0);
}

/// A texel at the tip of a chart has a negative value there, which no logarithm holds.
TEST(HeatSweeps, AgreeOnStretchedChartsButAtTheirTips) {
  EXPECT_LE(share_beyond(1e-3, fixtures::slanted(), 192), 0.01);
}

/// u_i = ρ^i with ρ + 1/ρ = 2 + 1/τ: far below the smallest double at the end.
TEST(HeatSweeps, KeepWhatNoDoubleHolds) {
  const int n = 5000;
  const double tau = 4;
  Entries entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1 + tau * (i + 1 < n ? 2 : 1));
    if (i + 1 < n) entries.emplace_back(i, i + 1, -tau), entries.emplace_back(i + 1, i, -tau);
  }
  const HeatSweeps heat =
      sweep_heat(sparse_matrix(n, n, entries), {{0, 0}}, {.tolerance = 1e-10, .max_sweeps = 200});
  const double kappa = std::acosh(1 + 1 / (2 * tau));
  EXPECT_LT(heat.log_u[4000], -1900);
  for (int i = 0; i < 4900; ++i) EXPECT_NEAR(heat.log_u[i], -kappa * i, 1e-6 * (1 + i));
}

}  // namespace
}  // namespace mq
