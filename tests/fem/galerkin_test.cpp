#include "mq/linear/galerkin.h"

#include <gtest/gtest.h>

#include <tuple>

#include "fem/patchwork.h"
#include "mq/fem/texel_hierarchy.h"

using namespace mq;

namespace {

SparseMatrix matrix_of(const LevelTransfer& P) {
  std::vector<Eigen::Triplet<double>> entries;
  std::array<WeightedIndex, 4> parents;
  for (int i = 0; i < P.fine_rows(); ++i)
    for (int p = 0, count = P.parents(i, parents); p < count; ++p)
      entries.emplace_back(i, parents[p].index, double(parents[p].weight));
  SparseMatrix matrix(P.fine_rows(), P.coarse_rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

// In closed form where both levels are grids, term by term elsewhere: at charts' borders, where charts
// are coarsened along one axis alone, and on the points of coarser levels.
TEST(Galerkin, IsTheProductOfTheThreeMatrices) {
  using fixtures::make_patchwork;
  for (const auto& p : {make_patchwork({.size = 60}), make_patchwork({.size = 60, .charts = 3}),
                        make_patchwork({.size = 60, .charts = 2, .stretch = 5})}) {
    SparseMatrix A = fixtures::system_of(p, 7);
    const Hierarchy hierarchy = texel_hierarchy(A, p.texels);
    ASSERT_GE(hierarchy.multigrid().levels.size(), 2U);
    for (const auto& level : hierarchy.multigrid().levels) {
      const SparseMatrix P = matrix_of(*level->transfer);
      const SparseMatrix expected = SparseMatrix(P.transpose()) * SparseMatrix(A * P);
      const SparseMatrix found = galerkin(A, *level->transfer);
      EXPECT_LE((found - expected).norm(), 1e-14 * expected.norm());
      for (int row = 0; row < found.rows(); ++row)
        for (int k = found.outerIndexPtr()[row] + 1; k < found.outerIndexPtr()[row + 1]; ++k)
          ASSERT_LT(found.innerIndexPtr()[k - 1], found.innerIndexPtr()[k]) << row;
      A = found;
    }
  }
}

// Of a Laplacian that has become one node nothing is left, not even rounding, which might be below 0; of a mass all is.
TEST(Galerkin, LeavesNothingOfAComponentOfOneNodeWhereConstantsAreTheNullSpace) {
  constexpr int n = 7;
  for (const double mass : {0.0, 1e-6}) {
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<WeightedIndex> parents;
    std::vector<int> starts = {0};
    for (int i = 0; i < n; ++i) {
      for (const int j : {(i + 1) % n, (i + 3) % n}) {
        const double weight = 1 / (1.7 + i * i + 0.3 * j);
        for (const auto& [row, column, sign] : {std::tuple{i, i, 1}, {j, j, 1}, {i, j, -1}, {j, i, -1}})
          entries.emplace_back(row, column, sign * weight);
      }
      entries.emplace_back(i, i, mass);
      parents.push_back({0, 1.0F});
      starts.push_back(i + 1);
    }
    SparseMatrix A(n, n);
    A.setFromTriplets(entries.begin(), entries.end());
    EXPECT_NE(A.sum(), n * mass);  // it would be rounding
    const SparseMatrix found = galerkin(A, SparseTransfer(starts, parents, 1));
    ASSERT_EQ(found.nonZeros(), 1);
    EXPECT_NEAR(found.coeff(0, 0), n * mass, 1e-9 * mass);
  }
}
