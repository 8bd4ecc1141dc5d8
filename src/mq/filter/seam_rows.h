#pragma once
/// What `smooth_at_seams` is made of, row by row: for who has some of the rows, and others the rest.

#include <vector>

#include "mq/fem/texel_space.h"
#include "mq/filter/seam_values.h"

namespace mq {

/// What the equation asks for, −A·ψ of these rows (others are 0): of `Smooth::values` that of the whole of A, which
/// `TexelSpace::regularised_system(0, 1)` of a space with soft seams is; of `Smooth::change` that of its seams alone.
Signal seam_imbalance(const TexelSpace& space, const SparseMatrix& A, const Signal& psi, const std::vector<int>& rows,
                      Smooth what);

/// The least and the greatest of a signal at some unknowns, by channel.
struct ValueRange {
  Eigen::RowVectorXd low, high;

  bool any() const { return low.size() > 0; }

  void extend(const Eigen::RowVectorXd& values);
  void extend(const ValueRange& other);

  /// By those that count (1) among i and its neighbours in A.
  void extend(const SparseMatrix& A, const Signal& psi, const std::vector<char>& counts, int i);

  /// Brings row i of a signal into the range, and a quarter of it more: a border goes on where its neighbours lead.
  /// Whether that changed it.
  bool bring_back(Signal& phi, int i) const;
};

}  // namespace mq
