#include "mq/linear/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
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

/// A vector is not solved for as a matrix of one column, whose sums are in another order.
template <class Right>
Right solved(const Eigen::MatrixXd& L, Right x) {
  L.triangularView<Eigen::Lower>().solveInPlace(x);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
  return x;
}

}  // namespace

SymmetricPairs<2> symmetric_pairs(const Eigen::Matrix2d& A) { return pairs_of<2>(A); }
SymmetricPairs<3> symmetric_pairs(const Eigen::Matrix3d& A) { return pairs_of<3>(A); }
SingularValues<2> singular_values(const Eigen::Matrix2d& A) { return decomposed<2>(A); }
SingularValues<3> singular_values(const Eigen::Matrix3d& A) { return decomposed<3>(A); }

bool DenseCholesky::compute(const Eigen::MatrixXd& A) {
  const Eigen::LLT<Eigen::MatrixXd> factor(A);
  L_ = factor.matrixLLT();
  return factor.info() == Eigen::Success;
}

Eigen::MatrixXd DenseCholesky::solve(const Eigen::MatrixXd& B) const { return solved(L_, B); }
Eigen::VectorXd DenseCholesky::solve(const Eigen::VectorXd& b) const { return solved(L_, b); }

}  // namespace mq
