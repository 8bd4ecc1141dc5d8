#include "mq/linear/error_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mq {
namespace {

TEST(ErrorEstimate, IsExactForStepsThatShrinkAlike) {
  for (const double rate : {0.15, 0.5, 0.9}) {
    ErrorEstimate error;
    EXPECT_TRUE(error.within(0));
    // x = 3 is approached from 0, every step leaving `rate` of what was missing.
    double missing = 3;
    for (int i = 0; i < 5; ++i) {
      const double change = missing * (1 - rate);
      missing *= rate;
      error.add_step(change, 3 - missing);
    }
    EXPECT_NEAR(error.relative(), missing / (3 - missing), 1e-12) << rate;
    EXPECT_TRUE(error.within(0.26 * error.relative()));
    EXPECT_FALSE(error.within(0.24 * error.relative()));
  }
}

TEST(ErrorEstimate, DoesNotTrustASingleGoodStep) {
  ErrorEstimate error;
  error.add_step(1, 1);
  error.add_step(0.9, 1);
  error.add_step(1e-9, 1);
  EXPECT_NEAR(error.relative(), 9e-9, 1e-12);
}

TEST(ErrorEstimate, IsNothingWhereNothingIsAskedFor) {
  ErrorEstimate error;
  error.add_step(0, 0);
  EXPECT_EQ(error.relative(), 0);
}

}  // namespace
}  // namespace mq
