// Levels, the transfers between them, and one cycle.
#include <gtest/gtest.h>

#include "atlas/atlas_fixtures.h"
#include "fem/patchwork.h"
#include "mq/fem/grid_levels.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/fem/texel_space.h"

namespace mq {
namespace {

using fixtures::make_patchwork;
using fixtures::signal_noise;
using fixtures::Patchwork;
using fixtures::system_of;

/// The matrix that the finest level stands for.
SparseMatrix scaled(const SparseMatrix& A, const Hierarchy& hierarchy) {
  SparseMatrix B = A;
  for (int i = 0; i < A.rows(); ++i)
    for (SparseMatrix::InnerIterator e(B, i); e; ++e)
      e.valueRef() *= hierarchy.scaling()(i, e.col());
  return B;
}

TEST(Patchwork, IsAPartitionOfUnityWithConstantsAsNullSpace) {
  for (const int charts : {1, 3}) {
    const Patchwork p = make_patchwork({.size = 40, .charts = charts, .stretch = 2});
    const Vector one = Vector::Ones(p.texels.size());
    EXPECT_NEAR(p.mass.sum(), 1, 1e-12);
    EXPECT_LT((p.stiffness * one).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// P·1 = 1, and children, restriction and prolongation are what parents say.
void expect_consistent(const LevelTransfer& P) {
  SparseMatrix by_rows(P.fine_rows(), P.coarse_rows()), by_columns = by_rows;
  std::vector<Eigen::Triplet<double>> rows, columns;
  std::array<WeightedIndex, 4> parents;
  for (int i = 0; i < P.fine_rows(); ++i) {
    double sum = 0;
    const int count = P.parents(i, parents);
    for (int j = 0; j < count; ++j) {
      rows.emplace_back(i, parents[j].index, parents[j].weight);
      sum += parents[j].weight;
    }
    EXPECT_NEAR(sum, 1, 1e-6) << i;  // weights are floats
  }
  for (int j = 0; j < P.coarse_rows(); ++j) {
    std::vector<WeightedIndex> children;
    P.children(j, children);
    EXPECT_FALSE(children.empty());
    for (const WeightedIndex& c : children) columns.emplace_back(c.index, j, c.weight);
  }
  by_rows.setFromTriplets(rows.begin(), rows.end());
  by_columns.setFromTriplets(columns.begin(), columns.end());
  EXPECT_EQ((by_rows - by_columns).norm(), 0);

  for (const int lanes : {1, 4}) {
    LaneVector fine(P.fine_rows(), lanes), coarse(P.coarse_rows(), lanes),
        back(P.fine_rows(), lanes);
    const Signal r = signal_noise(P.fine_rows(), lanes);
    for (Eigen::Index i = 0; i < r.size(); ++i) fine.data()[i] = float(r.data()[i]);
    P.restrict_to(lanes, fine.data(), coarse.data());
    P.prolongate_add(lanes, coarse.data(), back.data());
    const Signal expected = by_rows * (by_rows.transpose() * r).eval();
    for (Eigen::Index i = 0; i < r.size(); ++i)
      EXPECT_NEAR(back.data()[i], expected.data()[i], 2e-5);
  }
}

TEST(Hierarchy, ProlongsConstantsToConstantsAndRestrictsByTheTranspose) {
  const Patchwork p = make_patchwork({.size = 70, .charts = 3, .stretch = 1.3});
  const Hierarchy hierarchy = texel_hierarchy(system_of(p, 20), p.texels, {.coarsest_rows = 50});
  ASSERT_GE(hierarchy.multigrid().levels.size(), 3u);
  for (const auto& level : hierarchy.multigrid().levels) expect_consistent(*level->transfer);
}

/// A strip ten times as long as it is wide whose texture coordinates run to the right and back,
/// with a gap of this width between the two ways.
Mesh hairpin(double gap) {
  constexpr double length = 0.75, width = 0.12, bottom = 0.3;
  constexpr int steps = 40, bend = 12;
  Mesh mesh;
  double way = 0;
  const Vector2 turn(0.1 + length, bottom + width + gap / 2);
  const auto add = [&](double at, const Vector2& left, const Vector2& right) {
    for (const auto& [uv, side] : {std::pair(left, 0.0), std::pair(right, width)}) {
      mesh.positions.emplace_back(at, side, 0);
      mesh.uvs.push_back(uv);
    }
  };
  for (int i = 0; i <= steps; ++i, way += length / steps) {
    const double u = 0.1 + length * i / steps;
    add(way, {u, bottom}, {u, bottom + width});
  }
  for (int i = 1; i < bend; ++i, way += 0.2 / bend) {
    const double angle = M_PI * i / bend - M_PI / 2;
    const Vector2 out(0.4 * std::cos(angle), std::sin(angle));
    add(way, turn + (width + gap / 2) * out, turn + gap / 2 * out);
  }
  for (int i = steps; i >= 0; --i, way += length / steps) {
    const double u = 0.1 + length * i / steps;
    add(way, {u, bottom + 2 * width + gap}, {u, bottom + width + gap});
  }
  for (int i = 0; 2 * i + 3 < mesh.vertex_count(); ++i)
    for (const Triangle& t :
         {Triangle{2 * i, 2 * i + 2, 2 * i + 1}, {2 * i + 1, 2 * i + 2, 2 * i + 3}}) {
      mesh.triangles.push_back(t);
      mesh.corner_uvs.push_back(t);
    }
  return mesh;
}

TEST(Hierarchy, KeepsPartsOfAChartApartThatAGapNarrowerThanTheCoarseGridParts) {
  int with_a_wide_gap = 0;
  for (const double gap : {5.4, 1.4, 0.7}) {
    const auto model = fixtures::textured(hairpin(gap / 256), {{256, 256}});
    const TexelSpace space(model->surface, model->atlas);
    const SparseMatrix A = space.regularised_system(0, 1);
    const StencilLayout layout = make_robust_layout(A, space.texels());
    GridCoarsening grid = coarsen_grid(space.texels(), {{2, 2}});
    const int nodes = grid.coarse.size();
    part_sheets(A, space.texels(), layout, grid);
    expect_consistent(*grid.transfer);
    EXPECT_EQ(grid.coarse.size(), grid.transfer->coarse_rows());
    EXPECT_EQ(grid.coarse.size() > nodes, gap < 2) << gap;

    const Signal B = A * signal_noise(space.size(), 1);
    Signal X = Signal::Zero(space.size(), 1);
    const MultigridOptions options{.tolerance = 1e-8};
    const SolveReport report = multigrid_solver(space.texels(), options)(A, {})->solve(B, X);
    EXPECT_TRUE(report.converged);
    if (gap > 2) with_a_wide_gap = report.cycles;
    EXPECT_LE(report.cycles, with_a_wide_gap) << gap;
  }
}

/// Σ over rows of u·v, per column.
Vector products(const Signal& u, const Signal& v) {
  return (u.array() * v.array()).colwise().sum().transpose();
}

TEST(StencilMatrix, MultipliesAsTheMatrixItWasMadeFrom) {
  const Patchwork p = make_patchwork({.size = 90, .charts = 2});
  const SparseMatrix A = system_of(p, 5);
  const Hierarchy hierarchy = texel_hierarchy(A, p.texels);
  for (const int lanes : {1, 4}) {
    LaneVector x(A.rows(), lanes), b(A.rows(), lanes), y(A.rows(), lanes), r(A.rows(), lanes),
        q(A.rows(), lanes);
    const Signal X = signal_noise(A.rows(), lanes), Q = signal_noise(A.rows(), lanes, 7u);
    for (Eigen::Index i = 0; i < X.size(); ++i) {
      x.data()[i] = float(X.data()[i]);
      q.data()[i] = float(Q.data()[i]);
    }
    const StencilMatrix::Products sums =
        hierarchy.high().multiply(lanes, x.data(), q.data(), y.data());
    hierarchy.high().residual(lanes, b.data(), x.data(), r.data());
    const Signal Y = scaled(A, hierarchy) * X;
    for (int lane = 0; lane < lanes; ++lane) {
      const double size = X.col(lane).squaredNorm();
      EXPECT_NEAR(sums.with_product[lane], products(X, Y)[lane], 1e-6 * size);
      EXPECT_NEAR(sums.with_r[lane], products(X, Q)[lane], 1e-6 * size);
    }
    for (Eigen::Index i = 0; i < Y.size(); ++i) {
      EXPECT_NEAR(y.data()[i], Y.data()[i], 5e-6);
      EXPECT_NEAR(r.data()[i], -Y.data()[i], 5e-6);
    }
  }
}

/// A texel that is hardly visible gets a unit of its own, a power of two, in which its row is about as large as those around.
TEST(Hierarchy, BringsRowsThatAreHardlyVisibleToTheSizeOfOthers) {
  const Patchwork p = make_patchwork({.size = 60, .charts = 2});
  SparseMatrix A = system_of(p, 5);
  const std::vector<int> rows = make_robust_layout(A, p.texels).irregular;
  ASSERT_GT(rows.size(), 10U);
  const int weak = rows[rows.size() / 2];
  for (int i = 0; i < A.rows(); ++i)
    for (SparseMatrix::InnerIterator e(A, i); e; ++e)
      e.valueRef() *= std::pow(1e-5, (i == weak) + (int(e.col()) == weak));
  const Hierarchy hierarchy = texel_hierarchy(A, p.texels);
  const SparseMatrix B = scaled(A, hierarchy);
  double around = 0;
  for (SparseMatrix::InnerIterator e(A, weak); e; ++e)
    if (e.col() != weak) around = std::max(around, B.coeff(e.col(), e.col()));
  EXPECT_LT(A.coeff(weak, weak), 1e-9 * A.coeff(rows[0], rows[0]));
  EXPECT_GE(B.coeff(weak, weak), 0.49 * around);
  EXPECT_LE(B.coeff(weak, weak), 2.01 * around);
  const double unit = hierarchy.scaling().row(weak);
  EXPECT_EQ(std::exp2(std::round(std::log2(unit))), unit);
  EXPECT_EQ(hierarchy.scaling().row(rows[0]), 1);
}

TEST(Cycle, IsSymmetricAndReducesTheErrorInTheEnergyNorm) {
  for (const int charts : {1, 4}) {
    const Patchwork p = make_patchwork({.size = 80, .charts = charts});
    const SparseMatrix A = system_of(p, 50);
    const Hierarchy hierarchy = texel_hierarchy(A, p.texels);
    const SparseMatrix matrix = scaled(A, hierarchy);
    const Eigen::Index n = A.rows();
    Multigrid::Workspace workspace(hierarchy.multigrid(), 1);
    const auto cycle = [&](const Vector& b) {
      LaneVector in(n, 1), out(n, 1);
      for (Eigen::Index i = 0; i < n; ++i) in.data()[i] = float(b[i]);
      hierarchy.multigrid().cycle(in.data(), out.data(), workspace);
      return Vector(Eigen::Map<const Eigen::VectorXf>(out.data(), n).cast<double>());
    };
    const Vector u = signal_noise(n, 1, 1u).array() - 0.5, v = signal_noise(n, 1, 2u).array() - 0.5;
    const Vector Cu = cycle(u), Cv = cycle(v);
    EXPECT_NEAR(Cu.dot(v), u.dot(Cv), 1e-5 * Cu.norm() * v.norm());  // single precision
    Vector error = u;
    for (int i = 0; i < 12; ++i) {
      const double before = error.dot(matrix * error);
      error -= cycle(matrix * error);
      EXPECT_LT(error.dot(matrix * error), 0.25 * before) << i;
    }
  }
}

}  // namespace
}  // namespace mq
