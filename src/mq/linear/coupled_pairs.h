#pragma once
/// The pairs of unknowns that a symmetric matrix couples.

#include "mq/linear/matrix.h"

namespace mq {

/// Calls visit(i, j) for the entries with i < j, row by row.
template <class Visit>
void for_each_coupled_pair(const SparseMatrix& A, const Visit& visit) {
  for (int i = 0; i < A.rows(); ++i)
    for (SparseMatrix::InnerIterator it(A, i); it; ++it)
      if (it.col() > i) visit(i, int(it.col()));
}

}  // namespace mq
