// Products and sums over channels, of more rows than one block has.

#include "mq/linear/residual.h"

#include <gtest/gtest.h>

#include "linear/matrices.h"

namespace mq {
namespace {

constexpr int side = 200;  // 40,000 rows: three blocks of sums

TEST(Residual, IsThatOfEigen) {
  const SparseMatrix A = test::grid_laplacian(side, 0.5);
  for (const int channels : {1, 2, 3, 4, 5, 7}) {
    const Signal X = test::random_signal(side * side, channels, 1), B = test::random_signal(side * side, channels, 2);
    Signal Y;
    multiply(A, X, Y);
    const Signal wanted = A * X;
    EXPECT_LT((Y - wanted).cwiseAbs().maxCoeff(), 1e-14) << channels;
    EXPECT_LT((residual(A, X, B) - (B - wanted)).cwiseAbs().maxCoeff(), 1e-14) << channels;
  }
}

TEST(Residual, TakesMatricesThatAreNotCompressed) {
  SparseMatrix A = test::grid_laplacian(20, 0.5);
  const Signal X = test::random_signal(400, 3);
  Signal compressed, loose;
  multiply(A, X, compressed);
  A.uncompress();
  multiply(A, X, loose);
  EXPECT_TRUE(compressed == loose);
}

TEST(Residual, SumsEachChannelOfAllRows) {
  for (const int channels : {1, 3, 5}) {
    const Signal X = test::random_signal(side * side, channels, 3), Y = test::random_signal(side * side, channels, 4);
    const Eigen::RowVectorXd dots = channel_dots(X, Y);
    for (int c = 0; c < channels; ++c) EXPECT_NEAR(dots[c], X.col(c).dot(Y.col(c)), 1e-9) << channels << ", " << c;
  }
}

TEST(Residual, AddsEachChannelByItsOwnFactor) {
  const Signal X = test::random_signal(side * side, 3, 5), before = test::random_signal(side * side, 3, 6);
  const Eigen::RowVectorXd factors = Eigen::RowVector3d(0.5, -2, 0);
  Signal Y = before;
  add_scaled(Y, X, factors);
  EXPECT_LT((Y - before - X * factors.asDiagonal()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Residual, TheWorstRatioIsOfTheChannelThatIsFarthest) {
  EXPECT_DOUBLE_EQ(worst_ratio(Eigen::RowVector3d(4, 9, 1), Eigen::RowVector3d(16, 9, 100)), 1);
  EXPECT_DOUBLE_EQ(worst_ratio(Eigen::RowVector3d(4, 1, 1), Eigen::RowVector3d(16, 100, 0)), 0.5);
  EXPECT_EQ(worst_ratio(Eigen::RowVector2d(0, 3), Eigen::RowVector2d(0, 0)), 0);
}

}  // namespace
}  // namespace mq
