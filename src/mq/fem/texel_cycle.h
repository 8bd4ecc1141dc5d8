#pragma once
/// The multigrid cycle of a texel system as a preconditioner, for iterations that are run elsewhere.

#include <functional>
#include <memory>
#include <span>

#include "mq/fem/multigrid_solver.h"
#include "mq/linear/transfer.h"

namespace mq {

/// Z = C·R with C ≈ A⁻¹ symmetric and positive definite: one cycle of `multigrid_solver`, in single precision. Where
/// several processes share a model, A may be the rows and columns of some of its texels.
class TexelCycle {
 public:
  /// `texels` are those of the rows of A, in their order (texture, row, column). Takes what `multigrid_solver` takes;
  /// keeps nothing of A. Throws as that does.
  TexelCycle(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options = {},
             const Progress& progress = {});
  ~TexelCycle();
  TexelCycle(TexelCycle&&) noexcept;

  int rows() const;

  /// Any number of channels; Z is given its shape, and may be R.
  void apply(const Signal& R, Signal& Z) const;

  /// Visits the rows of P, rows × unknowns of the first level that has less than `share` of the rows, or of the
  /// coarsest: what functions of that level are at each texel. Columns ascend; rows sum to 1; entries below a hundredth are
  /// left out. Returns the number of columns. On the calling thread.
  int for_each_interpolated(double share,
                            const std::function<void(int row, std::span<const WeightedIndex> terms)>& visit) const;

  std::int64_t bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace mq
