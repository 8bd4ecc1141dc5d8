// Relaxation of stencils as plain loops have it; and sizes that solvers say of themselves.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "linear/matrices.h"
#include "mq/base/random.h"
#include "mq/linear/factorisation_bytes.h"
#include "mq/linear/interior_relaxation.h"

namespace mq {
namespace {

constexpr int grid_side = 13;  // of a grid whose inner unknowns are stencils

/// A symmetric matrix of 3 × 3 stencils, all nine values unlike.
SparseMatrix unlike_stencils() {
  const Random random(11);
  std::vector<Eigen::Triplet<double>> entries;
  std::uint64_t count = 0;
  for (int y = 0; y < grid_side; ++y)
    for (int x = 0; x < grid_side; ++x) {
      const int k = y * grid_side + x;
      entries.emplace_back(k, k, 6 + random.uniform(count++));
      for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 1), std::pair(0, 1), std::pair(1, 1)}) {
        if (x + dx < 0 || x + dx >= grid_side || y + dy >= grid_side) continue;
        const double value = -random.uniform(count++);
        entries.emplace_back(k, k + dy * grid_side + dx, value);
        entries.emplace_back(k + dy * grid_side + dx, k, value);
      }
    }
  SparseMatrix A(grid_side * grid_side, grid_side * grid_side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// One line of one block: the rows of the inner unknowns, each in two segments.
StencilBlocks inner_rows() {
  StencilBlocks blocks;
  blocks.rows = {0};
  for (int y = 1; y + 1 < grid_side; ++y) {
    for (const auto& [from, to] : {std::pair(1, 7), std::pair(7, grid_side - 1)}) {
      const int first = y * grid_side + from;
      blocks.segments.push_back({first, to - from, first - grid_side, first + grid_side});
    }
    blocks.rows.push_back(int(blocks.segments.size()));
  }
  blocks.blocks = {0, int(blocks.rows.size()) - 1};
  blocks.lines = {0, 1};
  blocks.even_lines = 1;
  return blocks;
}

template <class Real>
void expect_plain_sweeps(double tolerance) {
  const SparseMatrix A = unlike_stencils();
  InteriorRelaxation<Real> relaxation(inner_rows());
  relaxation.set_values(A);
  for (const int lanes : {1, 4}) {
    // Kernels load whole registers: some values before and behind.
    constexpr int margin = 32;
    std::vector<Real> x(std::size_t(grid_side * grid_side * lanes + 2 * margin), 0), b = x, r = x;
    const Signal X = test::random_signal(grid_side * grid_side, lanes, 1), B = test::random_signal(grid_side * grid_side, lanes, 2);
    for (Eigen::Index i = 0; i < X.size(); ++i) x[margin + i] = Real(X.data()[i]), b[margin + i] = Real(B.data()[i]);
    relaxation.residual(lanes, b.data() + margin, x.data() + margin, r.data() + margin);
    const Signal R = B - A * X;
    for (const SweepOrder order : {SweepOrder::plain, SweepOrder::temporal}) {
      std::vector<Real> relaxed = x;
      relaxation.relax(lanes, b.data() + margin, relaxed.data() + margin, 3, order);
      Signal wanted = X;
      for (int sweep = 0; sweep < 3; ++sweep)
        for (int y = 1; y + 1 < grid_side; ++y)
          for (int column = 1; column + 1 < grid_side; ++column) {
            const int k = y * grid_side + column;
            Eigen::RowVectorXd sum = B.row(k);
            for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
              if (entry.col() != k) sum -= entry.value() * wanted.row(entry.col());
            wanted.row(k) = sum / A.coeff(k, k);
          }
      for (int k = 0; k < grid_side * grid_side; ++k) {
        const int column = k % grid_side, y = k / grid_side;
        const bool inner = column > 0 && y > 0 && column + 1 < grid_side && y + 1 < grid_side;
        for (int lane = 0; lane < lanes; ++lane) {
          ASSERT_NEAR(relaxed[std::size_t(margin + k * lanes + lane)], wanted(k, lane), tolerance) << k << ", " << lanes;
          if (inner) ASSERT_NEAR(r[std::size_t(margin + k * lanes + lane)], R(k, lane), 10 * tolerance) << k;
        }
      }
    }
  }
}

TEST(InteriorRelaxation, IsPlainSweepsOverTheInnerUnknowns) {
  expect_plain_sweeps<double>(1e-13);
  expect_plain_sweeps<float>(2e-6);
}

TEST(InteriorRelaxation, HoldsTenNumbersForEachUnknown) {
  const std::int64_t unknowns = (grid_side - 2) * (grid_side - 2);
  const auto all = InteriorRelaxation<float>(inner_rows()).bytes();
  EXPECT_GE(all, 40 * unknowns);
  EXPECT_LE(all, 40 * unknowns + 24 * (2 * grid_side + 1));
  EXPECT_EQ(InteriorRelaxation<double>(inner_rows()).bytes() - all, 40 * unknowns);
}

TEST(StencilAnisotropy, IsTheRatioOfTheEigenvaluesOfItsSecondMoments) {
  const Random random(6);
  for (std::uint64_t n = 0; n < 20; ++n) {
    // Opposite neighbours alike, as symmetric matrices have them far from borders.
    const double east = random.uniform(4 * n), south = random.uniform(4 * n + 1), south_east = 0.6 * random.uniform(4 * n + 2),
                 south_west = 0.2 * random.uniform(4 * n + 3);
    const double centre = 2 * (east + south + south_east + south_west);
    const Stencil row = {-south_east, -south, -south_west, -east, centre, -east, -south_west, -south, -south_east};
    Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
    for (int j = 0; j < 9; ++j) {
      const Eigen::Vector2d d(j % 3 - 1, j / 3 - 1);
      if (j != 4) moments -= row[std::size_t(j)] * d * d.transpose();
    }
    const Eigen::Vector2d values = moments.selfadjointView<Eigen::Lower>().eigenvalues();
    if (values[0] < 0.02 * centre) continue;  // cut there
    EXPECT_NEAR(stencil_anisotropy(row), values[1] / values[0], 1e-9 * values[1] / values[0]) << n;
  }
}

TEST(FactorisationBytes, GrowALittleFasterThanUnknowns) {
  EXPECT_NEAR(factorisation_bytes(1 << 20) / factorisation_bytes(1 << 10), 1024 * 2, 1e-6);
  // Half to twice of what this grid's factor takes, by what it is made for: see docs/measurements/memory.md.
  EXPECT_GT(factorisation_bytes(1000000), 0.5e9);
  EXPECT_LT(factorisation_bytes(1000000), 4e9);
}

}  // namespace
}  // namespace mq
