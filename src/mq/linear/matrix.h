#pragma once
/// The matrix types that all rooms share.

#include <Eigen/SparseCore>

#include <vector>

#include "mq/base/eigen_alignment.h"

namespace mq {

using Vector = Eigen::VectorXd;
/// One column per channel; one row per unknown, a row's channels adjacent in memory.
using Signal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// Rows compressed; symmetric matrices are stored whole.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

/// Entries of a matrix, in any order.
using Entries = std::vector<Eigen::Triplet<double>>;

/// The matrix of these entries; those at one place add up.
inline SparseMatrix sparse_matrix(int rows, int columns, const Entries& entries) {
  SparseMatrix A(rows, columns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace mq
