// The cycle of a texel system: symmetric, at rest where the solution is, as large as it says.

#include <gtest/gtest.h>

#include <malloc.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/linear/direct.h"
#include "mq/linear/local_multigrid.h"

namespace mq {
namespace {

/// Texels of a square in four charts, which may lie in it stretched, and the levels of their system.
struct CycleSystem {
  fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {160, 160});
  TexelSpace space{cut.model->surface, cut.model->atlas};
  SparseMatrix A = space.regularised_system(1, std::pow(3 * space.scale().texel_spacing, 2));
  Hierarchy hierarchy = texel_hierarchy(A, space.texels());
};

LaneVector lanes_of(const Signal& values) {
  LaneVector v(values.rows(), int(values.cols()));
  for (Eigen::Index i = 0; i < values.size(); ++i) v.data()[i] = float(values.data()[i]);
  return v;
}

double product(const LaneVector& a, const LaneVector& b) {
  double sum = 0;
  for (std::int64_t i = 0; i < a.size(); ++i) sum += double(a.data()[i]) * double(b.data()[i]);
  return sum;
}

TEST(Cycle, IsSymmetricAndPositive) {
  const CycleSystem s;
  const Multigrid& multigrid = s.hierarchy.multigrid();
  for (const int lanes : {1, 4}) {
    Multigrid::Workspace workspace(multigrid, lanes);
    const LaneVector a = lanes_of(test::random_signal(s.A.rows(), lanes, 1)),
                     b = lanes_of(test::random_signal(s.A.rows(), lanes, 2));
    LaneVector Ca(s.A.rows(), lanes), Cb(s.A.rows(), lanes);
    multigrid.cycle(a.data(), Ca.data(), workspace);
    multigrid.cycle(b.data(), Cb.data(), workspace);
    EXPECT_GT(product(a, Ca), 0);
    EXPECT_NEAR(product(a, Cb), product(b, Ca), 1e-5 * std::sqrt(product(a, Ca) * product(b, Cb))) << lanes;
  }
}

TEST(Cycle, OnSomeRowsIsSymmetricToo) {
  const CycleSystem s;
  for (const double radius : {3.0, 20.0}) {  // around the middle, where all charts meet
    RowSet rows(s.space.size());
    for (int k = 0; k < s.space.size(); ++k) {
      const auto& p = s.space.texels().positions[k];
      if (std::hypot(p[0] - 0.5, p[1] - 0.5) < radius * s.space.scale().texel_spacing) rows.add(k);
    }
    LocalMultigrid local(s.hierarchy.multigrid(), 1);
    local.choose(rows);
    const auto cycled = [&](const Signal& b) {
      for (const int i : local.rows()) local.right_hand_side()[i] = float(b(i, 0));
      local.solve({.error = 0, .max_cycles = 1});
      Vector x = Vector::Zero(b.rows());
      for (const int i : local.rows()) x[i] = double(local.solution()[i]);
      return x;
    };
    const Signal a = test::random_signal(s.A.rows(), 1, 3), b = test::random_signal(s.A.rows(), 1, 4);
    const Vector Ca = cycled(a), Cb = cycled(b);
    double aa = 0, ab = 0, ba = 0, bb = 0;
    for (const int i : local.rows())
      aa += a(i, 0) * Ca[i], ab += a(i, 0) * Cb[i], ba += b(i, 0) * Ca[i], bb += b(i, 0) * Cb[i];
    EXPECT_NEAR(ab, ba, 1e-5 * std::sqrt(aa * bb)) << radius;
  }
}

TEST(Cycle, RelaxationLeavesTheSolution) {
  const CycleSystem s;
  const auto& levels = s.hierarchy.multigrid().levels;
  ASSERT_GT(levels.size(), 1u);
  for (const auto& level : levels) {
    const int rows = level->matrix.rows();
    for (const int lanes : {1, 4}) {
      const LaneVector x = lanes_of(test::random_signal(rows, lanes, 5)), zero(rows, lanes);
      LaneVector b(rows, lanes);
      level->matrix.residual(lanes, zero.data(), x.data(), b.data());  // −A·x
      for (std::int64_t i = 0; i < b.size(); ++i) b.data()[i] = -b.data()[i];
      for (const Order order : {Order::forward, Order::backward}) {
        LaneVector relaxed = lanes_of(test::random_signal(rows, lanes, 5));
        level->matrix.relax_stencils(lanes, b.data(), relaxed.data(), 2, order);
        level->patches.relax(level->matrix, lanes, b.data(), relaxed.data(), order);
        float worst = 0;
        for (std::int64_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(relaxed.data()[i] - x.data()[i]));
        EXPECT_LT(worst, 1e-4) << rows << ", " << lanes;
      }
    }
  }
}

TEST(Cycle, SaysHowMuchItHolds) {
  const CycleSystem s;
  const auto held = [] {
    const struct mallinfo2 info = mallinfo2();
    return double(info.uordblks) + double(info.hblkhd);
  };
  const double before = held();
  const Hierarchy hierarchy = texel_hierarchy(s.A, s.space.texels());
  const double taken = held() - before;
  if (taken == 0) GTEST_SKIP() << "the C library does not say how much is held";
  EXPECT_NEAR(double(hierarchy.bytes()), taken, 0.15 * taken);
}

}  // namespace
}  // namespace mq
