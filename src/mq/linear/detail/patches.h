#pragma once
/// Relaxation where a matrix is no stencil: exact solution on small overlapping sets of unknowns.

#include <span>
#include <vector>

#include "mq/linear/detail/block_order.h"
#include "mq/linear/row_set.h"
#include "mq/linear/stencil_matrix.h"

namespace mq {

/// A cover of the listed rows of a layout by patches. A patch is an irregular row together with the
/// listed rows it couples to; or a clustered row with those it depends on strongly, and these do,
/// up to 32: where a metric is stretched, a piece of a line of texels in whatever direction. Rows
/// already in a patch (of the latter kind, not at its end) get none of their own. One pass does
///
///     x_P ← x_P + (A_PP)⁻¹ (b − A·x)_P        patch after patch,
///
/// a multiplicative Schwarz method: it cannot increase ‖x − A⁻¹b‖_A, and a backward pass is the
/// adjoint of a forward one. With patches of one unknown it is Gauss–Seidel.
class PatchSmoother {
 public:
  enum class Kind {
    neighbours,  ///< as above: for seams, where few unknowns couple strongly
    single       ///< each irregular row alone: for coarse levels without stencils
  };

  PatchSmoother() = default;

  /// Chooses the patches by the pattern of A; `set_values` must follow.
  PatchSmoother(const SparseMatrix& A, const StencilLayout& layout, Kind kind);

  /// Inverts the patches of the scaled A, each with its diagonal raised by 1e-6 of itself (a patch
  /// that is a whole component of a semidefinite matrix has no inverse otherwise).
  void set_values(const SparseMatrix& A, const StencilLayout& layout, const Scaling& scaling);

  /// One pass over all patches.
  void relax(const StencilMatrix& A, int lanes, const float* b, float* x, Order order) const {
    relax(order_, A, lanes, b, x, order);
  }

  /// What of them lies wholly within some rows.
  struct Within {
    BlockOrder order;        ///< of the patches that do
    std::vector<int> alone;  ///< positions of the irregular rows in none of these, increasing
  };

  /// `positions` are those of the listed rows among `rows`, increasing.
  Within within(const RowSet& rows, const std::vector<int>& positions,
                const StencilLayout& layout) const;

  /// One pass over the patches of an order.
  void relax(const BlockOrder& some, const StencilMatrix& A, int lanes, const float* b, float* x,
             Order order) const;

  /// Whether patches are more than single rows.
  bool exact() const { return kind_ == Kind::neighbours; }

  int count() const { return int(starts_.size()) - 1; }
  std::int64_t bytes() const;

 private:
  void add_patch(std::span<const int> members);
  void cover_by_neighbours(const SparseMatrix& A, const StencilLayout& layout,
                           const std::vector<int>& position);
  void cover_by_clusters(const SparseMatrix& A, const StencilLayout& layout,
                         const std::vector<int>& position);

  Kind kind_ = Kind::single;
  std::vector<int> starts_ = {0};       ///< patch p has members_[starts_[p]] …
  std::vector<int> members_;            ///< positions among the listed rows
  std::vector<int> patch_of_;           ///< per position the patch that begins there, below 0: none
  std::vector<std::int64_t> inverses_;  ///< where the inverse of patch p begins in values_
  std::vector<float> values_;           ///< inverses, row by row; of single rows, by position
  BlockOrder order_;
};

}  // namespace mq
