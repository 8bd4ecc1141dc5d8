#pragma once
/// Rows that are no stencils. Included by kernels only (base/kernel_forms.h).

#include "mq/linear/kernels/stencil_kernels.h"
#include "mq/linear/kernels/vector_lanes.h"

namespace mq::MARQUETRY_FORM {

/// The row of the matrix at a position of the list.
inline int row_at(const ListedRows& A, int position) {
  return position < A.irregular_count ? A.irregular[position]
                                      : A.clustered[position - A.irregular_count];
}

/// (b − A·x) in the row at a position.
template <int lanes>
inline Floats<lanes> residual_at(const ListedRows& A, int position, const float* b, const float* x) {
  const std::int64_t k = row_at(A, position);
  Floats<lanes> sum = load<lanes>(b + k * lanes) - A.diagonal[k] * load<lanes>(x + k * lanes);
  for (std::int64_t e = A.start[position]; e < A.start[position + 1]; ++e)
    sum -= A.values[e] * load<lanes>(x + std::int64_t(A.columns[e]) * lanes);
  return sum;
}

}  // namespace mq::MARQUETRY_FORM
