#include "mq/linear/direct.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

using test::diagonal;
using test::grid_laplacian;
using test::random_signal;
using testing::HasSubstr;
using testing::ThrowsMessage;

class Factoring : public testing::TestWithParam<Factorisation> {};

INSTANTIATE_TEST_SUITE_P(Every, Factoring, testing::ValuesIn(factorisations()), [](const auto& kind) {
  return kind.param == Factorisation::cholmod ? "cholmod" : "eigen";
});

TEST_P(Factoring, SolvesAllChannelsAtOnce) {
  const SparseMatrix A = grid_laplacian(40, 0.01);
  const Signal X = random_signal(1600, 5);
  const DirectSolver solver(A, GetParam());
  EXPECT_LE((solver.solve(A * X) - X).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_GE(solver.factor_nonzeros(), (A.nonZeros() + A.rows()) / 2);
}

TEST_P(Factoring, SolvesLargeSystemsBySupernodesToo) {
  const SparseMatrix A = grid_laplacian(300, 0.01);
  const Signal X = random_signal(90000, 3);
  EXPECT_LE((DirectSolver(A, GetParam()).solve(A * X) - X).cwiseAbs().maxCoeff(), 1e-9);
}

/// Some BLAS share buffers between threads that call them at a time.
TEST_P(Factoring, GivesThreadsThatFactorAtATimeTheSolutionsOfEachAlone) {
  constexpr int threads = 4, rounds = 20;
  std::vector<SparseMatrix> A;
  std::vector<Signal> B, alone;
  for (int i = 0; i < threads; ++i) {
    A.push_back(grid_laplacian(60 + 5 * i, 0.01));
    B.push_back(random_signal(int(A[i].rows()), 2));
    alone.push_back(DirectSolver(A[i], GetParam()).solve(B[i]));
  }
  std::atomic<int> other = 0;
  std::vector<std::jthread> running;
  for (int i = 0; i < threads; ++i)
    running.emplace_back([&, i] {
      for (int round = 0; round < rounds; ++round)
        try {
          if (DirectSolver(A[i], GetParam()).solve(B[i]) != alone[i]) ++other;
        } catch (const NotPositiveDefinite&) {
          ++other;
        }
    });
  running.clear();
  EXPECT_EQ(other, 0);
}

TEST_P(Factoring, ReadsTheLowerTriangleOnly) {
  SparseMatrix A = grid_laplacian(10, 1);
  const Signal X = random_signal(100, 2);
  const Signal B = A * X;
  A.coeffRef(3, 4) = 1e3;
  EXPECT_LE((DirectSolver(A, GetParam()).solve(B) - X).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(Factoring, FactorsAnotherMatrixOfTheSamePattern) {
  const SparseMatrix A = grid_laplacian(20, 1), C = grid_laplacian(20, 0.1) * 3.0;
  const Signal X = random_signal(400, 1);
  DirectSolver solver(A, GetParam());
  solver.refactor(C);
  EXPECT_LE((solver.solve(C * X) - X).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_THROW(solver.refactor(grid_laplacian(19, 1)), InvalidInput);
  EXPECT_THROW(solver.refactor(diagonal(std::vector<double>(400, 1.0))), InvalidInput);
}

TEST_P(Factoring, NamesTheRowThatIsNotPositive) {
  std::vector<double> values(50, 1.0);
  values[17] = -2;
  EXPECT_THAT([&] { DirectSolver(diagonal(values), GetParam()); },
              ThrowsMessage<NotPositiveDefinite>(HasSubstr("row 17 of 50")));
  values[17] = 0;
  EXPECT_THAT([&] { DirectSolver(diagonal(values), GetParam()); },
              ThrowsMessage<NotPositiveDefinite>(HasSubstr("row 17 of 50")));
}

TEST_P(Factoring, RefusesIndefiniteMatricesOfAnySize) {
  EXPECT_THROW(DirectSolver(grid_laplacian(10, -0.1), GetParam()), SolverError);
  EXPECT_THROW(DirectSolver(grid_laplacian(300, -0.1), GetParam()), SolverError);
}

TEST_P(Factoring, RefusesToSolveAfterAFailure) {
  DirectSolver solver(grid_laplacian(5, 1), GetParam());
  EXPECT_THROW(solver.refactor(grid_laplacian(5, -1)), SolverError);
  EXPECT_THROW(solver.solve(random_signal(25, 1)), SolverError);
  solver.refactor(grid_laplacian(5, 1));
  EXPECT_TRUE(solver.solve(random_signal(25, 1)).allFinite());
}

TEST_P(Factoring, NamesTheEntryThatIsNotFinite) {
  SparseMatrix A = grid_laplacian(4, 1);
  A.coeffRef(5, 6) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { DirectSolver(A, GetParam()); },
              ThrowsMessage<InvalidInput>(HasSubstr("row 5, column 6")));
  A.coeffRef(5, 6) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(DirectSolver(A, GetParam()), InvalidInput);
}

TEST_P(Factoring, RefusesWhatIsNotSquareOrDoesNotFit) {
  EXPECT_THROW(DirectSolver(SparseMatrix(3, 4), GetParam()), InvalidInput);
  EXPECT_THROW(DirectSolver(diagonal({1, 2}), GetParam()).solve(random_signal(3, 1)), InvalidInput);
}

TEST_P(Factoring, TakesAnEmptyMatrix) {
  EXPECT_EQ(DirectSolver(SparseMatrix(0, 0), GetParam()).solve(Signal(0, 3)).cols(), 3);
}

TEST_P(Factoring, StopsWhenAsked) {
  std::atomic<bool> cancel = false;
  const auto stop_at_factor = [&](const ProgressEvent& e) { cancel = e.step == "factorisation"; };
  EXPECT_THROW(DirectSolver(grid_laplacian(20, 1), GetParam(), Progress(stop_at_factor, &cancel)),
               Cancelled);
}

/// A full n × n matrix, which is positive definite.
SparseMatrix full(int n) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) entries.emplace_back(i, j, i == j ? double(n) : 1);
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

TEST_P(Factoring, SaysBeforeWhatItTakes) {
  const int n = 60;
  const SparseMatrix A = full(n);
  DirectSolver solver = DirectSolver::analysed(A, GetParam());
  EXPECT_EQ(solver.cost().entries, n * (n + 1) / 2);
  EXPECT_EQ(solver.cost().operations, n * (n + 1) * (2 * n + 1) / 6);
  EXPECT_GE(solver.cost().bytes, 8 * solver.cost().entries);
  EXPECT_GT(solver.expected_seconds(), 0);
  EXPECT_THROW(solver.solve(random_signal(n, 1)), SolverError);
  solver.refactor(A);
  const Signal X = random_signal(n, 1);
  EXPECT_LE((solver.solve(A * X) - X).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(solver.expected_seconds(), solver.factor_seconds());
}

TEST_P(Factoring, ForeseesTheMemoryOfLargeFactors) {
  const SparseMatrix A = grid_laplacian(200, 0.01);
  DirectSolver solver = DirectSolver::analysed(A, GetParam());
  solver.refactor(A);
  EXPECT_GE(solver.cost().bytes, 8 * solver.factor_nonzeros());
  EXPECT_LE(solver.cost().bytes, 4 * 8 * solver.factor_nonzeros());
}

TEST_P(Factoring, StopsAmidALargeFactorisation) {
  // What takes less than a tenth of a second is not worth stopping, and CHOLMOD does 1,500 rows in that.
  const int size = GetParam() == Factorisation::cholmod ? 3000 : 1500;
  const SparseMatrix A = full(size);
  const Signal X = random_signal(size, 1);
  DirectSolver solver(A, GetParam());
  const double whole = solver.factor_seconds();
  std::atomic<bool> cancel = false;
  std::optional<Stopwatch> asked;
  const Progress progress(
      [&](const ProgressEvent&) {
        cancel = true;
        asked.emplace();
      },
      &cancel);
  EXPECT_THROW(solver.refactor(A, progress), Cancelled);
  ASSERT_TRUE(asked.has_value());  // so it had begun
  EXPECT_LT(asked->seconds(), 0.5 * whole);
  EXPECT_THROW(solver.solve(X), SolverError);
  solver.refactor(A);  // the one that goes on has a copy of its own
  EXPECT_LE((solver.solve(A * X) - X).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(Factoring, AsALinearSolverReportsTheResidual) {
  const SparseMatrix A = grid_laplacian(40, 1e-6);
  const Signal X = random_signal(1600, 3);
  Signal found = Signal::Zero(1600, 3);
  const SolveReport report = direct_solver(GetParam())(A, {})->solve(A * X, found);
  EXPECT_EQ(report.cycles, 1);
  EXPECT_TRUE(report.converged);
  ASSERT_EQ(report.residuals.size(), 2u);
  EXPECT_EQ(report.residuals[0], 1);
  EXPECT_LE(report.residuals[1], 1e-11);
  EXPECT_GT(report.residuals[1], 0);
  EXPECT_THAT(report.method, HasSubstr("direct ("));
}

TEST_P(Factoring, AsALinearSolverLeavesAnExactGuessAlone) {
  const SparseMatrix A = grid_laplacian(10, 1);
  const Signal X = random_signal(100, 2);
  Signal guess = Signal::Zero(100, 2);
  const SolveReport report = direct_solver(GetParam())(A, {})->solve(Signal::Zero(100, 2), guess);
  EXPECT_EQ(report.cycles, 0);
  EXPECT_TRUE(guess.isZero(0));
}

TEST_P(Factoring, AsALinearSolverRefusesNaN) {
  const auto solver = direct_solver(GetParam())(grid_laplacian(4, 1), {});
  Signal B = Signal::Zero(16, 1), X = Signal::Zero(16, 1);
  B(3, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solver->solve(B, X), SolverError);
}

TEST_P(Factoring, AsALinearSolverUpdates) {
  const auto solver = direct_solver(GetParam())(grid_laplacian(10, 1), {});
  const SparseMatrix C = grid_laplacian(10, 5);
  solver->update(C, {});
  const Signal X = random_signal(100, 2);
  Signal found = random_signal(100, 2, 7);
  solver->solve(C * X, found);
  EXPECT_LE((found - X).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Factorisations, AlwaysHoldEigen) {
  EXPECT_THAT(factorisations(), testing::Contains(Factorisation::eigen));
}

TEST(Factorisations, RefuseWhatThisBuildLacks) {
  const auto kinds = factorisations();
  if (std::find(kinds.begin(), kinds.end(), Factorisation::cholmod) != kinds.end())
    GTEST_SKIP() << "this build has CHOLMOD";
  EXPECT_THROW(DirectSolver(diagonal({1}), Factorisation::cholmod), Unsupported);
}

}  // namespace
}  // namespace mq
