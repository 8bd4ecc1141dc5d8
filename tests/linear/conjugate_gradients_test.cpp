#include "mq/linear/conjugate_gradients.h"

#include <algorithm>
#include <barrier>
#include <functional>
#include <limits>
#include <thread>

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

/// Two threads in the place of two processes, each with half of the rows.
class HalfSystems {
 public:
  explicit HalfSystems(const SparseMatrix& A) : A_(A), all_(A.rows(), 2) {}

  SharedSystem half(int which) {
    const auto first = which * A_.rows() / 2, count = A_.rows() / 2;
    return {.multiply =
                [this, first, count](const Signal& X, Signal& AX) {
                  together_.arrive_and_wait();
                  all_.middleRows(first, count) = X;
                  together_.arrive_and_wait();
                  AX = A_.middleRows(first, count) * all_;
                },
            .sum = [this, which](std::span<double> values) { combine(which, values, std::plus<>()); },
            .largest =
                [this, which](std::span<double> values) {
                  combine(which, values, [](double a, double b) { return std::max(a, b); });
                }};
  }

 private:
  template <class How>
  void combine(int which, std::span<double> values, const How& how) {
    of_each_[which].assign(values.begin(), values.end());
    together_.arrive_and_wait();
    std::transform(of_each_[0].begin(), of_each_[0].end(), of_each_[1].begin(), values.begin(), how);
    together_.arrive_and_wait();
  }

  const SparseMatrix& A_;
  Signal all_;
  std::vector<double> of_each_[2];
  std::barrier<> together_{2};
};

TEST(SharedSystem, IsSolvedByAllThatShareIt) {
  const SparseMatrix A = grid_laplacian(24, 0.05);
  const Signal B = random_signal(576, 2);
  const Vector inverse = Vector(A.diagonal()).cwiseInverse();
  HalfSystems systems(A);
  Signal halves[2];
  SolveReport reports[2];
  const auto solve = [&](int which) {
    halves[which] = Signal::Zero(288, 2);
    const auto jacobi = [&](const Signal& R, Signal& Z) { Z = inverse.segment(which * 288, 288).asDiagonal() * R; };
    reports[which] = conjugate_gradients(systems.half(which), B.middleRows(which * 288, 288), halves[which], jacobi,
                                         {.tolerance = 1e-10, .stop = ConjugateGradientOptions::Stop::residual_error});
  };
  std::thread other(solve, 1);
  solve(0);
  other.join();
  EXPECT_TRUE(reports[0].converged);
  EXPECT_EQ(reports[0].cycles, reports[1].cycles);
  EXPECT_EQ(reports[0].error, reports[1].error);
  EXPECT_LE(reports[0].error, 4e-10);
  const Signal exact = DirectSolver(A).solve(B);
  EXPECT_LE((halves[0] - exact.topRows(288)).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LE((halves[1] - exact.bottomRows(288)).cwiseAbs().maxCoeff(), 1e-8);
}

}  // namespace
}  // namespace mq
