#pragma once
/// How well conditioned a matrix is once its rows are scaled.

#include <Eigen/Eigenvalues>

#include <utility>

#include "mq/linear/matrix.h"

namespace mq::fixtures {

/// Largest eigenvalue of D⁻¹A and the ratio to the smallest.
inline std::pair<double, double> scaled_spectrum(const SparseMatrix& A) {
  const Eigen::VectorXd d = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd B = d.asDiagonal() * Eigen::MatrixXd(A) * d.asDiagonal();
  const auto values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(B, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[values.size() - 1], values[values.size() - 1] / values[0]};
}

}  // namespace mq::fixtures
