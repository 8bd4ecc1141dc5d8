// The economical solver factors where the factor is sparse and iterates where everything meets
// everything; the solution is the same.

#include "mq/linear/economical_solver.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "linear/matrices.h"

namespace mq {
namespace {

using test::grid_laplacian;
using test::random_signal;
using testing::StartsWith;

/// The Laplacian of a random graph of six edges a vertex, plus a tenth of the identity: any order
/// of elimination joins a third of all vertices to each other.
SparseMatrix expander(int n) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(0, n - 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 0.1);
    for (int k = 0; k < 3; ++k) {
      const int j = any(random);
      for (const auto& [a, b, value] : {std::tuple(i, i, 1.), {j, j, 1.}, {i, j, -1.}, {j, i, -1.}})
        entries.emplace_back(a, b, value);
    }
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SolveReport solve(const SparseMatrix& A, const Signal& exact, double within,
                  const EconomicalOptions& options = {}) {
  Signal found = Signal::Zero(exact.rows(), exact.cols());
  const SolveReport report = economical_solver(options)(A, {})->solve(A * exact, found);
  EXPECT_TRUE(report.converged);
  EXPECT_LE((found - exact).cwiseAbs().maxCoeff(), within) << report.method;
  return report;
}

TEST(Economical, FactorsWhatIsSparse) {
  const SolveReport report = solve(grid_laplacian(60, 0.01), random_signal(3600, 3), 1e-10);
  EXPECT_THAT(report.method, StartsWith("direct"));
}

TEST(Economical, IteratesWhereTheFactorWouldBeDense) {
  const SolveReport report = solve(expander(8000), random_signal(8000, 3), 1e-6);
  EXPECT_THAT(report.method, StartsWith("conjugate gradients"));
  EXPECT_GT(report.cycles, 5);
}

TEST(Economical, KeepsToTheFillAskedFor) {
  const SolveReport report =
      solve(grid_laplacian(60, 0.01), random_signal(3600, 3), 1e-6, {.most_fill = 0.5});
  EXPECT_THAT(report.method, StartsWith("conjugate gradients"));
}

}  // namespace
}  // namespace mq
