#include "mq/linear/conjugate_gradients.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using test::diagonal;
using test::grid_laplacian;
using test::random_signal;

TEST(ConjugateGradients, AgreeWithADirectSolution) {
  const SparseMatrix A = grid_laplacian(50, 0.05);
  const Signal B = random_signal(2500, 4);
  Signal X = Signal::Zero(2500, 4);
  const SolveReport report =
      conjugate_gradients(A, B, X, jacobi_preconditioner(A), {.tolerance = 1e-12});
  EXPECT_TRUE(report.converged);
  EXPECT_LE((X - DirectSolver(A).solve(B)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ConjugateGradients, EndAfterAsManyCyclesAsThereAreEigenvalues) {
  const SparseMatrix A = diagonal({1, 1, 4, 4, 9, 9, 9, 4, 1});
  const auto identity = [](const Signal& R, Signal& Z) { Z = R; };
  Signal X = Signal::Zero(9, 2);
  const SolveReport report =
      conjugate_gradients(A, random_signal(9, 2), X, identity, {.tolerance = 1e-13});
  EXPECT_EQ(report.cycles, 3);
  EXPECT_TRUE(report.converged);
}

TEST(ConjugateGradients, EndAfterOneCycleWithTheInverseAsPreconditioner) {
  const SparseMatrix A = grid_laplacian(20, 0.1);
  const DirectSolver exact(A);
  Signal X = random_signal(400, 3, 5);
  const auto inverse = [&](const Signal& R, Signal& Z) { Z = exact.solve(R); };
  EXPECT_EQ(conjugate_gradients(A, random_signal(400, 3), X, inverse).cycles, 1);
}

TEST(ConjugateGradients, TreatEveryChannelAsIfItWereAlone) {
  const SparseMatrix A = grid_laplacian(30, 0.01);
  Signal B = random_signal(900, 3);
  B.col(1) *= 1e9;
  B.col(2).setZero();
  Signal together = Signal::Zero(900, 3);
  conjugate_gradients(A, B, together, jacobi_preconditioner(A));
  for (int c = 0; c < 2; ++c) {
    Signal alone = Signal::Zero(900, 1);
    conjugate_gradients(A, B.col(c), alone, jacobi_preconditioner(A));
    EXPECT_LE((alone - together.col(c)).norm(), 1e-12 * alone.norm()) << "channel " << c;
  }
  EXPECT_TRUE(together.col(2).isZero(0));
}

TEST(ConjugateGradients, SolveTheSemidefiniteSystemOfEachComponent) {
  // Two grids side by side, coupled by nothing.
  const SparseMatrix half = grid_laplacian(12, 0);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<int> components;
  for (int part = 0; part < 2; ++part)
    for (int i = 0; i < 144; ++i) {
      components.push_back(part);
      for (SparseMatrix::InnerIterator e(half, i); e; ++e)
        entries.emplace_back(part * 144 + i, part * 144 + e.col(), e.value());
    }
  SparseMatrix A(288, 288);
  A.setFromTriplets(entries.begin(), entries.end());

  const Signal exact = random_signal(288, 2);
  Signal B = A * exact;
  B.array() += 0.25;  // a part that has no solution
  Signal X = random_signal(288, 2, 9);
  const Signal start = X;
  const SolveReport report = conjugate_gradients(
      A, B, X, jacobi_preconditioner(A), {.tolerance = 1e-12, .components = components});
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.residuals.back(), 1e-11);
  for (int part = 0; part < 2; ++part) {
    const auto rows = Eigen::seqN(part * 144, 144);
    EXPECT_NEAR(X(rows, 0).sum(), start(rows, 0).sum(), 1e-11);
    const Eigen::RowVectorXd shift = (X - exact)(rows, Eigen::all).colwise().mean();
    EXPECT_LE(((X - exact)(rows, Eigen::all).rowwise() - shift).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(ConjugateGradients, GiveEqualBitsForAnyNumberOfThreads) {
  const SparseMatrix A = grid_laplacian(200, 0.01);
  const Signal B = random_signal(40000, 3);
  const auto solve = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Signal X = Signal::Zero(40000, 3);
    conjugate_gradients(A, B, X, jacobi_preconditioner(A), {.tolerance = 1e-6});
    return X;
  };
  const Signal one = solve(1);
  EXPECT_TRUE(one == solve(2));
  EXPECT_TRUE(one == solve(7));
}

TEST(ConjugateGradients, SayWhenTheyDidNotConverge) {
  const SparseMatrix A = grid_laplacian(50, 1e-6);
  Signal X = Signal::Zero(2500, 1);
  const SolveReport report = conjugate_gradients(A, random_signal(2500, 1), X,
                                                 jacobi_preconditioner(A), {.max_cycles = 3});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.cycles, 3);
  EXPECT_EQ(report.residuals.size(), 4u);
}

TEST(ConjugateGradients, RefuseIndefiniteMatricesAndNaN) {
  const auto identity = [](const Signal& R, Signal& Z) { Z = R; };
  Signal X = Signal::Zero(2, 1), B = Signal::Ones(2, 1);
  EXPECT_THROW(conjugate_gradients(diagonal({1, -2}), B, X, identity), NotPositiveDefinite);
  EXPECT_THROW(jacobi_preconditioner(diagonal({1, 0})), NotPositiveDefinite);
  B(0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(conjugate_gradients(diagonal({1, 1}), B, X, identity), SolverError);
}

TEST(ConjugateGradients, AsALinearSolverUpdate) {
  const auto solver = conjugate_gradient_solver({.tolerance = 1e-13})(grid_laplacian(10, 1), {});
  const SparseMatrix C = grid_laplacian(10, 4);
  solver->update(C, {});
  const Signal X = random_signal(100, 2);
  Signal found = Signal::Zero(100, 2);
  solver->solve(C * X, found);
  EXPECT_LE((found - X).cwiseAbs().maxCoeff(), 1e-11);
}

}  // namespace
}  // namespace mq
