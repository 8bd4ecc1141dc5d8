#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fem/patchwork.h"
#include "fem/solver_checks.h"
#include "mq/baseline/reference_cycle.h"
#include "mq/fem/grid_levels.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::expect_refusals;
using fixtures::expect_to_stop;
using fixtures::make_patchwork;
using fixtures::signal_noise;
using fixtures::Patchwork;
using fixtures::system_of;
using Precision = ReferenceOptions::Precision;

constexpr double infinite = std::numeric_limits<double>::infinity();

SolveReport solve(const Patchwork& p, const SparseMatrix& A, const Signal& B, Signal& X,
                  const ReferenceOptions& options = {}) {
  return reference_solver(p.texels, options)(A, {})->solve(B, X);
}

template <class Real>
std::vector<Real> values(const Signal& X) {
  return {X.data(), X.data() + X.size()};
}

/// Per unknown whether it is in a segment.
std::vector<char> in_segments(const StencilBlocks& blocks, int rows) {
  std::vector<char> inside(rows, 0);
  for (const StencilRun& s : blocks.segments)
    for (int k = s.first; k < s.first + s.count; ++k) ++inside[k];
  return inside;
}

template <class Real>
class Relaxation : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Relaxation, Precisions);

TYPED_TEST(Relaxation, InTemporalBlocksGivesTheBitsOfPlainSweeps) {
  using Real = TypeParam;
  for (const int charts : {1, 3}) {
    const Patchwork p = make_patchwork({.size = 200, .charts = charts});
    const SparseMatrix A = system_of(p, 40);
    for (const int height : {1, 2, 16, 1000})
      for (const int lanes : {1, 4})
        for (const int sweeps : {1, 2, 3, 7}) {
          InteriorRelaxation<Real> interior(
              make_blocks(make_layout(A, p.texels), p.texels, height));
          interior.set_values(A);
          const auto b = values<Real>(signal_noise(A.rows(), lanes, 1));
          auto temporal = values<Real>(signal_noise(A.rows(), lanes, 2)), plain = temporal;
          const auto start = temporal;
          interior.relax(lanes, b.data(), temporal.data(), sweeps, SweepOrder::temporal);
          interior.relax(lanes, b.data(), plain.data(), sweeps, SweepOrder::plain);
          EXPECT_TRUE(temporal == plain) << height << " " << lanes << " " << sweeps;
          EXPECT_FALSE(temporal == start);
        }
  }
}

TEST(Relaxation, OfOneBlockIsGaussSeidelFromTopToBottom) {
  const Patchwork p = make_patchwork({.size = 60});
  const SparseMatrix A = system_of(p, 40);
  const StencilBlocks blocks = make_blocks(make_layout(A, p.texels), p.texels, 1000);
  InteriorRelaxation<double> interior(blocks);
  interior.set_values(A);
  const std::vector<char> inside = in_segments(blocks, int(A.rows()));
  const Signal B = p.mass * signal_noise(A.rows(), 1, 1);
  Signal X = signal_noise(A.rows(), 1, 2);
  std::vector<double> x = values<double>(X);
  interior.relax(1, B.data(), x.data(), 3);
  for (int sweep = 0; sweep < 3; ++sweep)
    for (int k = 0; k < A.rows(); ++k)
      if (inside[k]) X(k, 0) += (B(k, 0) - A.row(k).dot(X.col(0))) / A.coeff(k, k);
  for (int k = 0; k < A.rows(); ++k) EXPECT_NEAR(x[k], X(k, 0), 1e-13);
}

TEST(StencilBlocks, HoldEveryInteriorTexelOnceAndLinesOfOneKindDoNotCouple) {
  const Patchwork p = make_patchwork({.size = 300, .charts = 3});
  const SparseMatrix A = system_of(p, 1);
  const StencilBlocks blocks = make_blocks(make_layout(A, p.texels), p.texels, 16);
  const std::vector<char> inside = in_segments(blocks, int(A.rows()));
  for (int k = 0; k < A.rows(); ++k) EXPECT_EQ(int(inside[k]), int(A.row(k).nonZeros() == 9)) << k;

  std::vector<int> line_of(A.rows(), -1);
  const int lines = int(blocks.lines.size()) - 1;
  ASSERT_GT(blocks.even_lines, 1);
  ASSERT_GT(lines - blocks.even_lines, 1);
  for (int line = 0; line < lines; ++line)
    for (int s = blocks.rows[blocks.blocks[blocks.lines[line]]];
         s < blocks.rows[blocks.blocks[blocks.lines[line + 1]]]; ++s)
      for (int i = 0; i < blocks.segments[s].count; ++i)
        line_of[blocks.segments[s].first + i] = line;
  for (int k = 0; k < A.rows(); ++k)
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      const int a = line_of[k], b = line_of[entry.col()];
      if (a < 0 || b < 0 || a == b) continue;
      EXPECT_NE(a < blocks.even_lines, b < blocks.even_lines) << a << " " << b;
    }
}

TEST(ReferenceCycle, ProlongsConstantsToConstantsAndRestrictsByTheTranspose) {
  const Patchwork p = make_patchwork({.size = 70, .charts = 3, .stretch = 1.3});
  const ReferenceCycle<double> cycle(system_of(p, 20), p.texels, {});
  ASSERT_EQ(cycle.levels().size(), 3u);
  for (const auto& level : cycle.levels()) {
    const int fine = level.transfer->fine_rows(), coarse = level.transfer->coarse_rows();
    const Signal ones = Signal::Ones(coarse, 1), u = signal_noise(fine, 1, 1), v = signal_noise(coarse, 1, 2);
    Signal Pone = Signal::Zero(fine, 1), Pv = Pone, Ru(coarse, 1);
    level.interpolation.prolongate_add(1, ones.data(), Pone.data());
    EXPECT_TRUE((Pone.array() == 1).all());
    level.interpolation.prolongate_add(1, v.data(), Pv.data());
    level.interpolation.restrict_to(1, u.data(), Ru.data());
    EXPECT_NEAR(u.col(0).dot(Pv.col(0)), Ru.col(0).dot(v.col(0)), 1e-12 * u.norm() * v.norm());
    EXPECT_LT(coarse, fine);
  }
}

TEST(ReferenceCycle, ReducesTheErrorInTheEnergyNormAtEveryStep) {
  for (const int charts : {1, 4})
    for (const double stretch : {1.0, 8.0}) {
      const Patchwork p = make_patchwork({.size = 80, .charts = charts, .stretch = stretch});
      const SparseMatrix A = system_of(p, 50);
      const ReferenceCycle<double> cycle(A, p.texels, {});
      ReferenceCycle<double>::Workspace workspace(cycle, 1, 1);
      // The error of x for b = 0 is x.
      const Vector b = Vector::Zero(A.rows());
      Vector x = signal_noise(A.rows(), 1, 1).array() - 0.5;
      for (int i = 0; i < 20; ++i) {
        const double before = x.dot(A * x);
        cycle.cycle(b.data(), x.data(), workspace);
        EXPECT_LT(x.dot(A * x), before) << i;
      }
    }
}

TEST(Reference, ConvergesToTheDirectSolution) {
  for (const int charts : {1, 2, 22}) {
    const Patchwork p = make_patchwork({.size = 80, .charts = charts});
    for (const double ratio : {1.0, 100.0, 1e4}) {
      const SparseMatrix A = system_of(p, ratio);
      const Signal B = p.mass * signal_noise(A.rows(), 3);
      Signal X = Signal::Zero(A.rows(), 3);
      const SolveReport report = solve(p, A, B, X, {.tolerance = 1e-11, .max_cycles = 40});
      EXPECT_TRUE(report.converged);
      EXPECT_LT((X - DirectSolver(A).solve(B)).cwiseAbs().maxCoeff(), 1e-9)
          << charts << " " << ratio;
    }
  }
}

TEST(Reference, IsExactInOneCycleWhereAllTexelsAreAtTheBoundary) {
  const Patchwork p = make_patchwork({.size = 6, .charts = 6});
  const SparseMatrix A = system_of(p, 3);
  const Signal B = p.mass * signal_noise(A.rows(), 3);
  Signal X = Signal::Zero(A.rows(), 3);
  EXPECT_LT(solve(p, A, B, X, {.max_cycles = 1}).residuals.back(), 1e-12);
}

TEST(Reference, ConvergesAsTheWeightInTexelsSquaredSays) {
  const auto rate = [](int size) {
    const Patchwork p = make_patchwork({.size = size});
    const SparseMatrix A = system_of(p, 30);
    Signal X = Signal::Zero(A.rows(), 3);
    const SolveReport report = solve(p, A, p.mass * signal_noise(A.rows(), 3), X, {.tolerance = 1e-11});
    return std::pow(report.residuals[8] / report.residuals[2], 1.0 / 6);
  };
  const double coarse = rate(120), fine = rate(240);
  EXPECT_NEAR(fine, coarse, 0.1 * coarse);
}

TEST(Reference, SlowsDownWhereChartsAreStretched) {
  const auto cycles = [](double stretch) {
    const Patchwork p = make_patchwork({.size = 100, .stretch = stretch});
    const SparseMatrix A = system_of(p, 100);
    Signal X = Signal::Zero(A.rows(), 3);
    return solve(p, A, p.mass * signal_noise(A.rows(), 3), X).cycles;
  };
  EXPECT_LE(cycles(1), 10);
  EXPECT_GE(cycles(8), 3 * cycles(1));
}

TEST(Reference, InSinglePrecisionEndsAtThePublishedAccuracy) {
  const Patchwork p = make_patchwork({.size = 150, .charts = 2});
  const SparseMatrix A = system_of(p, 100);
  const Signal B = p.mass * signal_noise(A.rows(), 3), exact = DirectSolver(A).solve(B);
  const auto error = [&](Precision precision, int cycles) {
    Signal X = Signal::Zero(A.rows(), 3);
    solve(p, A, B, X, {.precision = precision, .tolerance = 0, .max_cycles = cycles});
    return (X - exact).norm() / exact.norm();
  };
  const double one = error(Precision::float64, 2);
  EXPECT_NEAR(error(Precision::float32, 2), one, 0.01 * one);
  EXPECT_LT(error(Precision::float32, 40), 1e-5);
  EXPECT_GT(error(Precision::float32, 40), 1e-9);
  EXPECT_LT(error(Precision::float64, 80), 1e-12);
}

TEST(Reference, GivesTheSameBitsForAnyNumberOfThreads) {
  const Patchwork p = make_patchwork({.size = 300, .charts = 3});
  const SparseMatrix A = system_of(p, 100);
  const Signal B = p.mass * signal_noise(A.rows(), 3);
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    Signal first;
    for (const int threads : {1, 2, 7}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      Signal X = Signal::Zero(A.rows(), 3);
      solve(p, A, B, X, {.precision = precision, .max_cycles = 5});
      if (first.size() == 0) first = X;
      EXPECT_TRUE(X == first) << threads;
    }
  }
}

TEST(Reference, ServesAnyNumberOfChannels) {
  const Patchwork p = make_patchwork({.size = 50, .charts = 2});
  const SparseMatrix A = system_of(p, 50);
  const DirectSolver direct(A);
  for (const int channels : {1, 2, 3, 4, 5, 9}) {
    const Signal B = p.mass * signal_noise(A.rows(), channels);
    Signal X = Signal::Zero(A.rows(), channels);
    const SolveReport report = solve(p, A, B, X, {.tolerance = 1e-10});
    EXPECT_LT((X - direct.solve(B)).cwiseAbs().maxCoeff(), 1e-8) << channels;
    EXPECT_EQ(int(report.residuals.size()), report.cycles + 1);
  }
}

TEST(Reference, TakesNewValuesAsIfMadeForThem) {
  const Patchwork p = make_patchwork({.size = 80, .charts = 3});
  const SparseMatrix before = system_of(p, 5), after = system_of(p, 500);
  const auto solver = reference_solver(p.texels)(before, {});
  solver->update(after, {});
  const Signal B = p.mass * signal_noise(after.rows(), 3);
  Signal X = Signal::Zero(after.rows(), 3), Y = X;
  solver->solve(B, X);
  solve(p, after, B, Y);
  EXPECT_TRUE(X == Y);
}

TEST(Reference, SolvesWhereConstantsHaveNoEnergyAndKeepsTheSum) {
  for (const int charts : {1, 3, 20}) {
    const Patchwork p = make_patchwork({.size = 60, .charts = charts});
    const SparseMatrix A = system_of(p, infinite);
    const Signal wanted = signal_noise(A.rows(), 3);
    const Signal B = A * wanted + 1e-3 * (p.mass * Signal::Ones(A.rows(), 3));
    Signal X = Signal::Constant(A.rows(), 3, 2);
    const SolveReport report = solve(p, A, B, X, {.max_cycles = 1000});
    EXPECT_TRUE(report.converged) << charts;
    EXPECT_NEAR(X.mean(), 2, 1e-12);
    Signal dropped = B;
    dropped.rowwise() -= B.colwise().mean().eval();
    EXPECT_LT((A * X - dropped).norm(), 2e-6 * dropped.norm()) << charts;
  }
}

TEST(Reference, SolvesNothingInNoTimeAndLeavesASolutionAsItIs) {
  Signal nothing(0, 3);
  EXPECT_EQ(reference_solver(Texels{})(SparseMatrix(0, 0), {})->solve(Signal(0, 3), nothing).cycles,
            0);
  const Patchwork p = make_patchwork({.size = 40});
  const SparseMatrix A = system_of(p, 50);
  const Signal exact = signal_noise(A.rows(), 3);
  Signal X = exact;
  EXPECT_EQ(solve(p, A, A * exact, X).cycles, 0);
  EXPECT_TRUE(X == exact);
}

TEST(Reference, SaysWhatIsWrongWithItsInput) {
  expect_refusals([](const Texels& texels) { return reference_solver(texels); });
  const Patchwork p = make_patchwork({.size = 20});
  EXPECT_THROW(reference_solver(p.texels, {.grids = 1})(system_of(p, 3), {}), InvalidInput);
}

TEST(Reference, StopsWhenAskedTo) {
  expect_to_stop([](const Texels& texels) { return reference_solver(texels); });
}

}  // namespace
}  // namespace mq
