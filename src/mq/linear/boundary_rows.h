#pragma once
/// The part of a matrix that is solved for directly while the rest is held (domain decomposition).

#include <cstdint>
#include <vector>

#include "mq/linear/kernels/relaxation_kernels.h"
#include "mq/linear/matrix.h"

namespace mq {

/// The rows of A at some unknowns, the boundary; all other unknowns are the interior. Vectors are
/// rows × lanes (1 or 4), a row's lanes adjacent. Real is float or double.
template <class Real>
class BoundaryRows {
 public:
  BoundaryRows() = default;
  BoundaryRows(const SparseMatrix& A, std::vector<int> boundary);

  const std::vector<int>& boundary() const { return boundary_; }
  void set_values(const SparseMatrix& A);

  /// A_bb.
  SparseMatrix block(const SparseMatrix& A) const;

  /// b_b − A_bi·x_i, one row per unknown at the boundary, `channels` of the lanes.
  Signal interior_relative_residual(int lanes, int channels, const Real* b, const Real* x) const;

  /// r_b = (b − A·x)_b.
  void residual(int lanes, const Real* b, const Real* x, Real* r) const;

  std::int64_t bytes() const;

 private:
  using Entry = RowEntry<Real>;

  std::vector<int> boundary_;
  std::vector<int> position_;  ///< per unknown its index in boundary_, −1: interior
  std::vector<std::int64_t> starts_, middles_;  ///< of a row's entries: at interior unknowns first
  std::vector<Entry> entries_;
};

extern template class BoundaryRows<float>;
extern template class BoundaryRows<double>;

}  // namespace mq
