#pragma once
/// The matrix of a texel system, its rows spread over processes, in PETSc.

#include <optional>
#include <span>

#include "mq/linear/conjugate_gradients.h"
#include "mq/linear/matrix.h"
#include "halo.h"
#include "petsc.h"

namespace mq::shared {

class SharedMatrix {
 public:
  /// Takes the rows of a part's own texels from the matrix of its space. Every process must call it. Throws
  /// `InvalidInput` where there are more texels than PETSc's numbers count, `SolverError` for errors of PETSc.
  SharedMatrix(const SparseMatrix& A, const Processes& processes, const TexelPart& part, const Numbering& numbering);

  Mat matrix() const { return matrix_; }
  std::int64_t own_rows() const { return rows_; }

  /// AX = A·X of the own rows, all channels in one walk through the matrix. Every process must call it.
  void multiply(const Signal& X, Signal& AX) const;

  /// Visits channel after channel of X and of Y (which is given X's shape, and may be X) as vectors of PETSc's:
  /// visit(x, y).
  template <class Visit>
  void for_each_channel(const Signal& X, Signal& Y, const Visit& visit) const {
    Y.resize(X.rows(), X.cols());
    for (Eigen::Index c = 0; c < X.cols(); ++c) {
      put_channel(X, c, x_);
      visit(Vec(x_), Vec(y_));
      take_channel(y_, c, Y);
    }
  }

 private:
  void find_blocks(const Processes& processes, const Numbering& numbering);

  OwnedMat matrix_;
  Mat own_block_ = nullptr, other_block_ = nullptr;  ///< columns of this process, and of others; parts of `matrix_`
  std::optional<Halo> halo_;                         ///< the columns of others
  OwnedVec x_, y_;
  std::int64_t rows_ = 0;
};

/// What conjugate gradients ask of the matrix and of all processes; both must outlive it.
SharedSystem shared_system(const SharedMatrix& matrix, const Processes& processes);

}  // namespace mq::shared
