#include "mq/linear/eigen.h"

#include <algorithm>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/linear/solver.h"

namespace mq {
namespace {

using test::diagonal;
using test::grid_laplacian;

TEST(SmallestEigenpairs, AreThoseOfADiagonalPencil) {
  std::vector<double> a, b;
  for (int i = 0; i < 60; ++i) a.push_back((i * 37) % 60), b.push_back(1 + i % 3);
  std::vector<double> expected;
  for (int i = 0; i < 60; ++i) expected.push_back(a[i] / b[i]);
  std::sort(expected.begin(), expected.end());
  const EigenPairs pairs = smallest_eigenpairs(diagonal(a), diagonal(b), {.count = 12});
  for (int k = 0; k < 12; ++k) EXPECT_NEAR(pairs.values[k], expected[k], 1e-12);
}

TEST(SmallestEigenpairs, AgreeWithADenseDecomposition) {
  const SparseMatrix A = grid_laplacian(30, 0.01), B = grid_laplacian(30, 2);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> dense(
      Eigen::MatrixXd(A), Eigen::MatrixXd(B), Eigen::EigenvaluesOnly);
  for (const int count : {1, 7, 40}) {
    const EigenPairs pairs = smallest_eigenpairs(A, B, {.count = count});
    EXPECT_LE((pairs.values - dense.eigenvalues().head(count)).cwiseAbs().maxCoeff(), 1e-12) << count;
  }
}

TEST(SmallestEigenpairs, AreOrthonormalAndHaveNoResidual) {
  const SparseMatrix A = grid_laplacian(40, 0), B = grid_laplacian(40, 3);
  const EigenPairs pairs = smallest_eigenpairs(A, B, {.count = 15});
  const Eigen::MatrixXd residual =
      A * pairs.vectors - B * pairs.vectors * pairs.values.asDiagonal();
  EXPECT_LE(residual.cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::MatrixXd gram = pairs.vectors.transpose() * (B * pairs.vectors);
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(15, 15)).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(SmallestEigenpairs, FindWholeNullSpacesAndEigenspaces) {
  std::vector<double> a(1000, 0.0);
  for (int i = 0; i < 1000; ++i) a[(i * 77) % 1000] = i < 9 ? 0 : i < 24 ? 1 : i;
  const EigenPairs pairs = smallest_eigenpairs(diagonal(a), diagonal(std::vector<double>(1000, 1.0)),
                                               {.count = 26});
  for (int k = 0; k < 26; ++k)
    EXPECT_NEAR(pairs.values[k], k < 9 ? 0 : k < 24 ? 1 : k, 1e-10) << k;
}

TEST(SmallestEigenpairs, AreFoundHoweverManyOfASmallMatrix) {
  for (const int side : {1, 2, 5, 9}) {
    const SparseMatrix A = grid_laplacian(side, 0), B = grid_laplacian(side, 3);
    for (const int count : {1, side, side * side}) {
      const EigenPairs pairs = smallest_eigenpairs(A, B, {.count = count});
      const Eigen::MatrixXd residual =
          A * pairs.vectors - B * pairs.vectors * pairs.values.asDiagonal();
      EXPECT_LE(residual.cwiseAbs().maxCoeff(), 1e-12) << side << " " << count;
      EXPECT_NEAR(pairs.values[0], 0, 1e-12);
    }
  }
}

/// A pencil with negative eigenvalues and vectors without mass, beside a decomposition with another shift: as a dense
/// one, and by Lanczos.
TEST(SmallestEigenpairs, OfAnyPencilAreTheFiniteOnesFromTheLowestOn) {
  for (const int side : {12, 30}) {
    const int n = side * side, count = 10;
    std::vector<double> less, mass;
    for (int i = 0; i < n; ++i) {
      less.push_back(i % 11 == 0 ? -7 - 0.01 * i : 0.1);
      mass.push_back(i % 5 == 2 ? 0 : 1 + i % 3);
    }
    mass[0] = mass[1] = 1;
    for (int i = 0; i < n; ++i)
      if (mass[std::size_t(i)] == 0) less[std::size_t(i)] = 0.1;
    const SparseMatrix A = grid_laplacian(side, 0) + diagonal(less), B = diagonal(mass);
    const double below = 60;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> dense(
        Eigen::MatrixXd(B), Eigen::MatrixXd(A) + below * Eigen::MatrixXd(B), Eigen::EigenvaluesOnly);
    EXPECT_THROW(smallest_eigenpairs(A, B, {.count = count}), NotPositiveDefinite);
    const EigenPairs pairs = smallest_eigenpairs(A, B, {.pencil = EigenOptions::Pencil::any, .count = count});
    EXPECT_LT(pairs.values[0], -2);
    for (int k = 0; k < count; ++k)
      EXPECT_NEAR(pairs.values[k], 1 / dense.eigenvalues()[n - 1 - k] - below, 1e-8) << side << " " << k;
    const Eigen::MatrixXd residual = A * pairs.vectors - B * pairs.vectors * pairs.values.asDiagonal();
    EXPECT_LE(residual.cwiseAbs().maxCoeff(), 1e-7);
    const Eigen::MatrixXd gram = pairs.vectors.transpose() * (B * pairs.vectors);
    EXPECT_LE((gram - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(SmallestEigenpairs, OfAnyPencilAreNoMoreThanAreFinite) {
  const EigenOptions three{.pencil = EigenOptions::Pencil::any, .count = 3};
  EXPECT_THROW(smallest_eigenpairs(diagonal({1, 2, 3}), diagonal({1, 0, 1}), three), SolverError);
  // What has neither mass nor stiffness leaves every combination singular.
  EXPECT_THROW(smallest_eigenpairs(diagonal({1, 0, 3}), diagonal({1, 0, 1}), three), NotPositiveDefinite);
}

TEST(SmallestEigenpairs, RefuseWhatIsNoPencil) {
  EXPECT_THROW(smallest_eigenpairs(diagonal({1, 2}), diagonal({1, 2, 3})), InvalidInput);
  EXPECT_THROW(smallest_eigenpairs(diagonal({1, 2}), diagonal({1, 1}), {.count = 3}), InvalidInput);
  EXPECT_THROW(smallest_eigenpairs(diagonal({-5, 2}), diagonal({1, 1}), {.count = 1}),
               NotPositiveDefinite);
}

}  // namespace
}  // namespace mq
