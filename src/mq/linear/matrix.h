#pragma once
/// The matrix types that all rooms share.

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace mq {

using Vector = Eigen::VectorXd;
/// One column per channel; one row per unknown, a row's channels adjacent in memory.
using Signal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// Rows compressed; symmetric matrices are stored whole.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

}  // namespace mq
