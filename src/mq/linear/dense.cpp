#include "mq/linear/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace mq {
namespace {

template <int n>
SymmetricPairs<n> pairs_of(const Eigen::Matrix<double, n, n>& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int n>
SingularValues<n> decomposed(const Eigen::Matrix<double, n, n>& A) {
  const Eigen::JacobiSVD<Eigen::Matrix<double, n, n>> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

}  // namespace

SymmetricPairs<2> symmetric_pairs(const Eigen::Matrix2d& A) { return pairs_of<2>(A); }
SymmetricPairs<3> symmetric_pairs(const Eigen::Matrix3d& A) { return pairs_of<3>(A); }
SingularValues<2> singular_values(const Eigen::Matrix2d& A) { return decomposed<2>(A); }
SingularValues<3> singular_values(const Eigen::Matrix3d& A) { return decomposed<3>(A); }

Eigen::Matrix3d nearest_rotation(const SingularValues<3>& A) {
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if ((A.U * A.V.transpose()).determinant() < 0) signs[2] = -1;
  return A.U * signs.asDiagonal() * A.V.transpose();
}

bool DenseCholesky::compute(const Eigen::MatrixXd& A) {
  const Eigen::LLT<Eigen::MatrixXd> factor(A);
  L_ = factor.matrixLLT();
  return factor.info() == Eigen::Success;
}

Eigen::MatrixXd DenseCholesky::solve(const Eigen::MatrixXd& B) const {
  Eigen::MatrixXd X = B;
  L_.triangularView<Eigen::Lower>().solveInPlace(X);
  L_.transpose().triangularView<Eigen::Upper>().solveInPlace(X);
  return X;
}

Eigen::VectorXd solve_positive(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.ldlt().solve(b);
}

}  // namespace mq
