/// With OP = (A − σB)⁻¹B, symmetric in the inner product of B, and V a basis orthonormal in it, each
/// step appends the block W = OP·V_last, orthogonalised, so that
///
///     OP·V = V·T + W_next·R·Eᵀ,      T = VᵀB·OP·V.
///
/// An eigenpair T·s = θ·s gives λ = σ + 1/θ and x = V·s with residual ‖R·Eᵀ·s‖. Spectra has Lanczos
/// from one vector, which sees one direction of each eigenspace and the others only by rounding;
/// spheres and tori have eigenspaces of any dimension, so a block it is. There is no restart: for
/// the tens or hundreds of pairs wanted here, the basis fits.
///
/// Rounding leaves an error of about 10⁻¹⁶·λ²/|σ| in λ. For the Laplacian of a surface tr A / (n·tr B)
/// is about its first eigenvalue, which makes a shift neither too small for the accuracy of the
/// others nor too large to tell them apart.
///
/// Vectors x without mass, B·x = 0, are no eigenvectors of OP but for θ = 0, and the range of OP has none of them: a
/// first block taken from there keeps V out of them, and OP·x/θ takes out what rounding brought back (Nour-Omid, Parlett,
/// Ericsson and Jensen, How to implement the spectral transformation, 1987).

#include "mq/linear/eigen.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/linear/solver.h"

namespace mq {

namespace {

using Matrix = Eigen::MatrixXd;

/// Directions of a block shorter than this, relative to its longest, are rounding.
constexpr double rank_tolerance = 1e-12;

/// Rows up to which a dense decomposition is taken: a second of work.
constexpr Eigen::Index most_dense = 800;

Matrix random_block(Eigen::Index rows, int columns) {
  const Random random(1);
  Matrix X(rows, columns);
  for (Eigen::Index i = 0; i < X.size(); ++i)
    X.data()[i] = random.uniform(std::uint64_t(i), -1, 1);
  return X;
}

/// −tr A / (n·tr B); where A is 0, anything below 0 will do.
double shift_for(const SparseMatrix& A, const SparseMatrix& B) {
  const double trace = std::abs(A.diagonal().sum());
  return -(trace > 0 ? trace / double(A.rows()) : 1) / B.diagonal().sum();
}

/// Times σ is lowered fourfold, by 10¹²; and times the step is halved then, to within 5 % of the lowest eigenvalue,
/// as those that lie close to each other are told apart by a near shift alone.
constexpr int most_shifts = 20, halvings = 6;

/// A − σB factored by `factor(σ)`, which throws `NotPositiveDefinite`, with the first σ of these that will do.
template <class Factor>
double lowered_shift(double shift, const EigenOptions& options, const Factor& factor) {
  const auto works = [&](double s, int tries_left) {
    try {
      factor(s);
      return true;
    } catch (const NotPositiveDefinite&) {
      if (options.pencil == EigenOptions::Pencil::semidefinite || tries_left == 0) throw;
      return false;
    }
  };
  double failed = shift;
  for (int tries = most_shifts; !works(shift, tries); --tries) {
    failed = shift;
    shift *= 4;
  }
  if (failed == shift) return shift;
  double made = shift;
  for (int n = 0; n < halvings; ++n) {
    made = (shift + failed) / 2;
    (works(made, 1) ? shift : failed) = made;
  }
  if (made != shift) factor(shift);
  return shift;
}

/// Makes every column's largest component positive.
void turn(Matrix& vectors) {
  for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
    Eigen::Index largest = 0;
    vectors.col(k).cwiseAbs().maxCoeff(&largest);
    if (vectors(largest, k) < 0) vectors.col(k) *= -1;
  }
}

/// All pairs at once, of which the first are returned: where a basis would nearly be the whole space,
/// its last blocks are rounding.
EigenPairs dense_pairs(const SparseMatrix& A, const SparseMatrix& B, int count) {
  const Matrix dense_B(B);
  if (Eigen::LLT<Matrix>(dense_B).info() != Eigen::Success)
    throw NotPositiveDefinite("the second matrix of the pencil is not positive definite");
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> all(Matrix(A), dense_B);
  if (all.eigenvalues()[0] <= shift_for(A, B))
    throw NotPositiveDefinite("the first matrix of the pencil is not positive semidefinite");
  EigenPairs result{all.eigenvalues().head(count), all.eigenvectors().leftCols(count)};
  turn(result.vectors);
  return result;
}

[[noreturn]] void throw_too_few(int wanted, Eigen::Index found) {
  throw SolverError(fmt::format("of the {} smallest eigenvalues wanted, {} are finite; ask for fewer", wanted, found));
}

/// The same of any pencil, as B·x = μ·(A − σB)·x with μ = 1/(λ − σ).
EigenPairs dense_pairs_of_any(const SparseMatrix& A, const SparseMatrix& B, const EigenOptions& options) {
  const Matrix dense_A(A), dense_B(B);
  const double shift = lowered_shift(shift_for(A, B), options, [&](double s) {
    if (Eigen::LLT<Matrix>(dense_A - s * dense_B).info() != Eigen::Success)
      throw NotPositiveDefinite("no combination of both matrices of the pencil that was tried is positive definite");
  });
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> all(dense_B, dense_A - shift * dense_B);
  const Vector mu = all.eigenvalues().reverse();
  EigenPairs result{Vector(options.count), Matrix(A.rows(), options.count)};
  for (int k = 0; k < options.count; ++k) {
    if (!(mu[k] > rank_tolerance * mu[0])) throw_too_few(options.count, k);
    result.values[k] = shift + 1 / mu[k];
    result.vectors.col(k) = all.eigenvectors().col(A.rows() - 1 - k) / std::sqrt(mu[k]);
  }
  turn(result.vectors);
  return result;
}

class BlockLanczos {
 public:
  BlockLanczos(const SparseMatrix& A, const SparseMatrix& B, const EigenOptions& options,
               const Progress& progress)
      : B_(B), options_(options) {
    const Progress step = progress.step("factor", 0.5);
    shift_ = lowered_shift(shift_for(A, B), options,
                           [&](double shift) { inverse_.emplace(A - shift * B, options.factorisation, step); });
  }

  EigenPairs run(const Progress& progress) {
    const int block = options_.block > 0 ? options_.block : std::clamp(options_.count, 4, 24);
    const Eigen::Index limit = std::min<Eigen::Index>(B_.rows(), 20 * options_.count + 400);
    Matrix next = random_block(B_.rows(), std::min<int>(block, int(B_.rows())));
    if (options_.pencil == EigenOptions::Pencil::any) next = inverse_->solve(Signal(B_ * next));
    orthonormalise(next);
    while (next.cols() > 0) {
      append(next);
      if (V_.cols() + next.cols() > limit && V_.cols() < B_.rows()) break;
      if (converged() >= options_.count) break;
      progress.at(double(converged()) / options_.count);
    }
    if (converged() < options_.count)
      throw SolverError(fmt::format("of the {} smallest eigenvalues wanted, {} were found with {} "
                                    "vectors; ask for fewer",
                                    options_.count, converged(), V_.cols()));
    return pairs();
  }

 private:
  /// Takes V out of W and makes W orthonormal in B, dropping directions that vanish. Returns R of W_before = V·(...) + W·R.
  Matrix orthonormalise(Matrix& W) {
    const int columns = int(W.cols());
    Matrix R = Matrix::Identity(columns, columns);
    const double scale = W.norm();
    for (int pass = 0; pass < 2; ++pass) {
      if (V_.cols() > 0) W -= V_ * (V_.transpose() * (B_ * W));
      const Eigen::SelfAdjointEigenSolver<Matrix> gram(W.transpose() * (B_ * W));
      const Vector lengths = gram.eigenvalues().cwiseMax(0).cwiseSqrt();
      const double longest = lengths.size() > 0 ? lengths.maxCoeff() : 0;
      if (!(W.norm() > rank_tolerance * scale)) return keep(W, R, Matrix(W.cols(), 0), lengths);
      Eigen::Index first = 0;  // eigenvalues ascend
      while (lengths[first] <= rank_tolerance * longest) ++first;
      const Eigen::Index rank = lengths.size() - first;
      R = keep(W, R, gram.eigenvectors().rightCols(rank), lengths.tail(rank));
    }
    return R;
  }

  /// W ← W·Q / lengths, R ← lengths·Qᵀ·R.
  static Matrix keep(Matrix& W, const Matrix& R, const Matrix& Q, const Vector& lengths) {
    if (Q.cols() == 0) {
      W.resize(W.rows(), 0);
      return Matrix(0, R.cols());
    }
    W = W * Q * lengths.cwiseInverse().asDiagonal();
    return lengths.asDiagonal() * Q.transpose() * R;
  }

  /// Appends `block` to V, extends T and leaves the next block in it.
  void append(Matrix& block) {
    const Eigen::Index before = V_.cols(), size = before + block.cols();
    V_.conservativeResize(B_.rows(), size);
    V_.rightCols(block.cols()) = block;
    Matrix W = inverse_->solve(Signal(B_ * block));
    Matrix T = Matrix::Zero(size, size);
    T.topLeftCorner(before, before) = T_;
    const Matrix products = V_.transpose() * (B_ * W);
    T.rightCols(block.cols()) = products;
    T.bottomRows(block.cols()) = products.transpose();
    T_ = 0.5 * (T + T.transpose());
    const Eigen::Index last = block.cols();
    R_ = orthonormalise(W);
    block = std::move(W);
    ritz_.compute(T_);
    const Matrix tails = R_ * ritz_.eigenvectors().bottomRows(last);
    residuals_ = tails.colwise().norm().transpose();
  }

  /// How many of the largest θ in a row have a small residual.
  int converged() const {
    int found = 0;
    const auto& theta = ritz_.eigenvalues();
    for (Eigen::Index i = theta.size() - 1; i >= 0 && found < options_.count; --i, ++found)
      if (!(residuals_[i] <= options_.tolerance * theta[i])) break;
    return found;
  }

  EigenPairs pairs() const {
    EigenPairs result;
    result.values.resize(options_.count);
    const Eigen::Index size = T_.rows();
    for (int k = 0; k < options_.count; ++k)
      result.values[k] = shift_ + 1 / ritz_.eigenvalues()[size - 1 - k];
    result.vectors = V_ * ritz_.eigenvectors().rightCols(options_.count).rowwise().reverse();
    if (options_.pencil == EigenOptions::Pencil::any) {
      result.vectors = inverse_->solve(Signal(B_ * result.vectors));
      for (int k = 0; k < options_.count; ++k) {
        auto x = result.vectors.col(k);
        x /= std::sqrt(x.dot(B_ * x));
      }
    }
    turn(result.vectors);
    return result;
  }

  const SparseMatrix& B_;
  EigenOptions options_;
  double shift_ = 0;
  std::optional<DirectSolver> inverse_;
  Matrix V_, T_, R_;
  Eigen::SelfAdjointEigenSolver<Matrix> ritz_;
  Vector residuals_;
};

}  // namespace

EigenPairs smallest_eigenpairs(const SparseMatrix& A, const SparseMatrix& B,
                               const EigenOptions& options, const Progress& progress) {
  require(A.rows() == A.cols() && B.rows() == B.cols() && A.rows() == B.rows(),
          fmt::format("eigenvalues of a pencil of {} × {} and {} × {}: both must be square and "
                      "of one size", A.rows(), A.cols(), B.rows(), B.cols()));
  require(options.count > 0 && options.count <= A.rows(),
          fmt::format("{} eigenvalues of a matrix of {} rows were asked for", options.count,
                      A.rows()));
  require(B.diagonal().sum() > 0, "the second matrix of the pencil is not positive definite");
  const bool any = options.pencil == EigenOptions::Pencil::any;
  if (A.rows() <= most_dense) return any ? dense_pairs_of_any(A, B, options) : dense_pairs(A, B, options.count);
  BlockLanczos lanczos(A, B, options, progress);
  return lanczos.run(progress.step("iterate", 0.5));
}

}  // namespace mq
