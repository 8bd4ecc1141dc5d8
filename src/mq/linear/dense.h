#pragma once
/// Small dense problems, by Eigen's solvers, which are compiled here once: each costs a compiler seconds.

#include <Eigen/Core>
#include <Eigen/LU>

namespace mq {

/// Eigenvalues λ of a symmetric matrix, ascending, and unit eigenvectors as columns.
template <int n>
struct SymmetricPairs {
  Eigen::Matrix<double, n, 1> values;
  Eigen::Matrix<double, n, n> vectors;
};
SymmetricPairs<2> symmetric_pairs(const Eigen::Matrix2d& A);
SymmetricPairs<3> symmetric_pairs(const Eigen::Matrix3d& A);

/// A = U · diag(values) · Vᵀ, values descending and not negative.
template <int n>
struct SingularValues {
  Eigen::Matrix<double, n, n> U;
  Eigen::Matrix<double, n, 1> values;
  Eigen::Matrix<double, n, n> V;
};
SingularValues<2> singular_values(const Eigen::Matrix2d& A);
SingularValues<3> singular_values(const Eigen::Matrix3d& A);

/// The R of determinant 1 with the largest trace(RᵀA): the rotation that takes points p nearest to
/// points q where A = Σ q·pᵀ.
inline Eigen::Matrix3d nearest_rotation(const SingularValues<3>& A) {
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if ((A.U * A.V.transpose()).determinant() < 0) signs[2] = -1;
  return A.U * signs.asDiagonal() * A.V.transpose();
}

/// A symmetric matrix as L·Lᵀ.
class DenseCholesky {
 public:
  /// Returns false where A is not positive definite to rounding; there is nothing to solve with then.
  bool compute(const Eigen::MatrixXd& A);

  /// The X with A·X = B.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const;
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  Eigen::MatrixXd L_;  ///< the upper half is not used
};

}  // namespace mq
