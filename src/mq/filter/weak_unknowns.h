#pragma once
/// Unknowns that hardly meet the surface, where signals are stitched.

#include <span>
#include <vector>

#include "mq/linear/matrix.h"

namespace mq {

/// Unknowns around which others of their region have five times their S_ii: texels that hardly meet the surface. Next to a
/// border such a texel is told a step of its own, by cells of which it has a small part, and little else speaks for a
/// value there; so its change is brought into the range of theirs.
class WeakUnknowns {
 public:
  /// Of these rows; `diagonal` is that of S.
  WeakUnknowns(const SparseMatrix& stiffness, const Vector& diagonal, std::span<const int> labels,
               std::span<const int> rows);

  /// Puts what was `asked` into δ, brought into that range, those that meet the surface more first. Whether anything in δ
  /// changed: where rows beside them are of other parts of a space, to be done again once these are fetched.
  bool bound(const Signal& asked, Signal& delta) const;

 private:
  std::vector<int> rows_;
  std::vector<std::vector<int>> beside_;
};

}  // namespace mq
