#include "mq/linear/block_multigrid.h"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "linear/matrices.h"
#include "mq/base/random.h"

namespace mq {
namespace {

using test::random_signal;

/// Unknown i of a chain in a frame turned by an angle of its own; neighbours coupled so that
/// parallel vectors cost nothing, plus a mass.
struct Chain {
  BlockMatrix<double> A;
  std::vector<double> angles;
};

Chain chain(int n, double mass) {
  Chain c;
  const Random random(5);
  for (int i = 0; i < n; ++i) c.angles.push_back(random.uniform(i, -3, 3));
  for (int i = 0; i < n; ++i) {
    for (const int j : {i - 1, i, i + 1}) {
      if (j < 0 || j >= n) continue;
      const double turn = c.angles[i] - c.angles[j];
      c.A.columns.push_back(j);
      if (i == j) {
        const double d = mass + (i > 0) + (i + 1 < n);
        c.A.blocks.push_back({d, 0, 0, d});
      } else {
        c.A.blocks.push_back({-std::cos(turn), std::sin(turn), -std::sin(turn), -std::cos(turn)});
      }
    }
    c.A.starts.push_back(int(c.A.columns.size()));
  }
  return c;
}

/// Every second unknown, linear interpolation, turned from frame to frame.
std::vector<std::shared_ptr<const BlockTransfer>> transfers(std::vector<double> angles) {
  std::vector<std::shared_ptr<const BlockTransfer>> all;
  while (angles.size() > 20) {
    auto P = std::make_shared<BlockTransfer>();
    const int n = int(angles.size());
    std::vector<double> coarse;
    for (int i = 0; i < n; i += 2) coarse.push_back(angles[i]);
    P->columns = int(coarse.size());
    for (int i = 0; i < n; ++i) {
      const auto term = [&](int j, double w) {
        const double turn = angles[i] - coarse[j];
        P->entries.push_back({j, float(w * std::cos(turn)), float(w * std::sin(turn))});
      };
      if (i % 2 == 0)
        term(i / 2, 1);
      else if (i + 1 < n)
        term(i / 2, 0.5), term(i / 2 + 1, 0.5);
      else
        term(i / 2, 1);
      P->starts.push_back(int(P->entries.size()));
    }
    P->finish();
    all.push_back(P);
    angles = coarse;
  }
  return all;
}

TEST(BlockMultigrid, SolvesToTheToleranceInFewCycles) {
  const Chain c = chain(5000, 1e-4);
  BlockMultigrid multigrid(transfers(c.angles), {.tolerance = 1e-9});
  multigrid.set_matrix(c.A);
  const Vector b = random_signal(10000, 1);
  Vector x = Vector::Zero(10000);
  const SolveReport report = multigrid.solve(b, x);
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.cycles, 12);
  EXPECT_LE((b - scalar_matrix(c.A) * x).norm(), 1.1e-9 * b.norm());
}

TEST(BlockMultigrid, WithoutLevelsIsAFactorisation) {
  const Chain c = chain(60, 0.1);
  BlockMultigrid multigrid({}, {.tolerance = 1e-6});
  multigrid.set_matrix(c.A);
  const Vector b = random_signal(120, 1);
  Vector x = Vector::Zero(120);
  EXPECT_LE(multigrid.solve(b, x).cycles, 2);
  EXPECT_LE((b - scalar_matrix(c.A) * x).norm(), 1e-6 * b.norm());
}

TEST(BlockMultigrid, KeepsItsLevelsForAnotherMatrix) {
  const Chain c = chain(3000, 1e-3), other = chain(3000, 10);
  BlockMultigrid multigrid(transfers(c.angles), {.tolerance = 1e-8});
  const Vector b = random_signal(6000, 1);
  for (const Chain* matrix : {&c, &other}) {
    multigrid.set_matrix(matrix->A);
    Vector x = Vector::Zero(6000);
    EXPECT_TRUE(multigrid.solve(b, x).converged);
    EXPECT_LE((b - scalar_matrix(matrix->A) * x).norm(), 1.1e-8 * b.norm());
  }
}

TEST(BlockMultigrid, LeavesAPerfectGuessAlone) {
  const Chain c = chain(1000, 0.1);
  BlockMultigrid multigrid(transfers(c.angles), {.tolerance = 1e-6});
  multigrid.set_matrix(c.A);
  const Vector x = random_signal(2000, 1);
  Vector guess = x;
  EXPECT_EQ(multigrid.solve(scalar_matrix(c.A) * x, guess).cycles, 0);
  EXPECT_EQ(guess, x);
}

TEST(BlockMultigrid, GivesTheSameBitsForAnyNumberOfThreads) {
  const Chain c = chain(20000, 1e-3);
  const Vector b = random_signal(40000, 1);
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    BlockMultigrid multigrid(transfers(c.angles), {.tolerance = 1e-8});
    multigrid.set_matrix(c.A);
    Vector x = Vector::Zero(40000);
    multigrid.solve(b, x);
    return x;
  };
  const Vector one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(7), one);
}

TEST(BlockMultigrid, RefusesMatricesThatAreNotPositive) {
  Chain c = chain(100, 0.1);
  for (auto& block : c.A.blocks)
    for (double& v : block) v = -v;
  BlockMultigrid multigrid(transfers(c.angles));
  EXPECT_THROW(multigrid.set_matrix(c.A), NotPositiveDefinite);
  EXPECT_THROW(multigrid.set_matrix(chain(99, 1).A), InvalidInput);
}

TEST(BlockTransfer, CarriesParallelFieldsExactly) {
  const Chain c = chain(1000, 0);
  const auto P = transfers(c.angles).front();
  Vector coarse(2 * P->columns);
  for (int j = 0; j < P->columns; ++j)
    coarse.segment<2>(2 * j) << std::cos(c.angles[2 * j] + 1), std::sin(c.angles[2 * j] + 1);
  const Vector fine = P->prolongated(coarse);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_NEAR(fine[2 * i], std::cos(c.angles[i] + 1), 1e-6);
    EXPECT_NEAR(fine[2 * i + 1], std::sin(c.angles[i] + 1), 1e-6);
  }
}

}  // namespace
}  // namespace mq
