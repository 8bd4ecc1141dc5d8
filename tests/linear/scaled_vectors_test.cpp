// What conjugate gradients do to vectors of one and four channels, with rows of units of their own: as in
// plain loops in double precision.

#include "mq/linear/detail/scaled_vectors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "linear/matrices.h"

namespace mq {
namespace {

constexpr int rows = 70001;  // more values than a block has, also of one channel
constexpr int special_rows[] = {0, 17, 40000, rows - 1};

Scaling scaling_with_special_rows() {
  Scaling scaling;
  scaling.rows.assign(rows, 1);
  float factor = 1.0f / 1024;
  for (const int row : special_rows) {
    scaling.rows[row] = factor;
    scaling.special.push_back({row, 1 / factor});
    factor *= 4;
  }
  return scaling;
}

LaneVector random_lanes(int lanes, unsigned seed) {
  LaneVector v(rows, lanes);
  const Signal values = test::random_signal(rows, lanes, seed);
  for (std::int64_t i = 0; i < v.size(); ++i) v.data()[i] = float(values.data()[i]);
  return v;
}

Double4 factors(int lanes) { return lanes == 1 ? Double4{} + 0.75 : Double4{0.75, -0.5, 0.125, 2}; }

double at(const LaneVector& v, int row, int lane) { return v.data()[std::int64_t(row) * v.lanes() + lane]; }

/// ‖D⁻¹·v‖² of a lane.
double squared(const Scaling& scaling, const LaneVector& v, int lane) {
  double sum = 0;
  for (int row = 0; row < rows; ++row) sum += std::pow(at(v, row, lane) / scaling.rows[row], 2);
  return sum;
}

TEST(ScaledVectors, SumsAreOfAllRowsOfEachChannel) {
  const Scaling scaling = scaling_with_special_rows();
  for (const int lanes : {1, 4}) {
    const LaneVector a = random_lanes(lanes, 1), b = random_lanes(lanes, 2);
    const Double4 found = dot(a, b);
    LaneVector r = random_lanes(lanes, 3);
    const LaneVector before = random_lanes(lanes, 3);
    const Double4 norm = squared_norm(scaling, r);
    for (int lane = 0; lane < lanes; ++lane) {
      double wanted = 0;
      for (int row = 0; row < rows; ++row) wanted += at(a, row, lane) * at(b, row, lane);
      EXPECT_NEAR(found[lane], wanted, 1e-3) << lanes;
      EXPECT_NEAR(norm[lane], squared(scaling, before, lane), 1e-6 * norm[lane]) << lanes;
      for (const int row : special_rows) EXPECT_EQ(at(r, row, lane), at(before, row, lane));
    }
  }
}

TEST(ScaledVectors, TheResidualIsReducedInSpecialRowsToo) {
  const Scaling scaling = scaling_with_special_rows();
  for (const int lanes : {1, 4}) {
    LaneVector q = random_lanes(lanes, 4), r = random_lanes(lanes, 5);
    const LaneVector q_before = random_lanes(lanes, 4), r_before = random_lanes(lanes, 5);
    const Double4 alpha = factors(lanes), norm = reduce_residual(scaling, q, alpha, r);
    for (int lane = 0; lane < lanes; ++lane) {
      for (int row = 0; row < rows; ++row) {
        ASSERT_NEAR(at(r, row, lane), at(r_before, row, lane) - alpha[lane] * at(q_before, row, lane), 1e-6)
            << lanes << ", " << row;
        ASSERT_EQ(at(q, row, lane), at(q_before, row, lane));
      }
      EXPECT_NEAR(norm[lane], squared(scaling, r, lane), 1e-6 * norm[lane]) << lanes;
    }
  }
}

TEST(ScaledVectors, ADirectionGoesOnWithPartOfTheLast) {
  for (const int lanes : {1, 4}) {
    const LaneVector z = random_lanes(lanes, 6), before = random_lanes(lanes, 7);
    LaneVector p = random_lanes(lanes, 7);
    const Double4 beta = factors(lanes);
    next_direction(z, beta, p);
    for (int row = 0; row < rows; ++row)
      for (int lane = 0; lane < lanes; ++lane)
        ASSERT_NEAR(at(p, row, lane), at(z, row, lane) + beta[lane] * at(before, row, lane), 1e-6) << row;
  }
}

TEST(ScaledVectors, TheSolutionGrowsInItsChannelsAlone) {
  const Scaling scaling = scaling_with_special_rows();
  for (const int channels : {1, 2, 3, 4}) {
    const int lanes = lanes_for(channels), first = 1;
    LaneVector p = random_lanes(lanes, 8);
    for (const int row : special_rows) p.data()[std::int64_t(row) * lanes] = 100;
    const Signal before = test::random_signal(rows, 6, 9);
    Signal X = before;
    const Double4 alpha = factors(lanes);
    const LargestValues found = add_to_solution(scaling, p, alpha, first, channels, X);
    for (int c = 0; c < 6; ++c) {
      double change = 0, value = 0;
      const int lane = c - first;
      const bool grows = lane >= 0 && lane < channels;
      for (int row = 0; row < rows; ++row) {
        const double wanted = grows ? alpha[lane] * at(p, row, lane) : 0;
        ASSERT_NEAR(X(row, c), before(row, c) + wanted, 1e-12) << channels << ", " << row;
        if (scaling.rows[row] != 1) continue;
        change = std::max(change, std::abs(wanted)), value = std::max(value, std::abs(X(row, c)));
      }
      if (!grows) continue;
      EXPECT_NEAR(found.change[lane], change, 1e-12);
      EXPECT_NEAR(found.value[lane], value, 1e-12);
    }
  }
}

}  // namespace
}  // namespace mq
