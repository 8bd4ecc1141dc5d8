#pragma once
/// What is done to every value of a `StencilMatrix`, in the forms of base/kernel_forms.h. Vectors are
/// rows × lanes (1, 4 or 8; 1 or 4 for products), a row's lanes adjacent, with `LaneVector::margin` zeros on both sides.

#include <cstdint>

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

/// Rows first … first + count − 1; row first + i couples to the unknowns up + i + {−1, 0, 1},
/// first + i + {−1, 0, 1} and down + i + {−1, 0, 1} and to no other.
struct StencilRun {
  int first = 0;
  int count = 0;  ///< at most `StencilLayout::max_run`
  int up = 0;
  int down = 0;
};

/// Five values per unknown k: A(k, k) and A(k, its right, lower left, lower, lower right neighbour).
struct StencilStreams {
  const float *c, *e, *sw, *s, *se;
};

/// Rows that are no stencils, by position: first the irregular ones, then the clustered.
struct ListedRows {
  const int* irregular;  ///< rows of the matrix
  int irregular_count;
  const int* clustered;
  const std::int64_t* start;  ///< entries start[p] … start[p + 1] − 1 beside the diagonal
  const int* columns;
  const float* values;
  const float* diagonal;  ///< by row of the matrix
};

/// The vectors of a product: y = A·x, and r, by which x is multiplied.
struct ProductVectors {
  const float *x, *r;
  float* y;
};

/// ⟨x, A·x⟩ and ⟨x, r⟩ per lane.
struct ProductSums {
  double with_product[4] = {}, with_r[4] = {};
};

/// Some of a list: positions[begin … end − 1], or, where there are none, begin … end − 1 themselves.
struct Selection {
  const int* positions;
  std::int64_t begin, end;
};

struct StencilKernels {
  /// One Gauss–Seidel sweep over runs in their order, even unknowns first; or backward.
  void (*relax_forward)(int lanes, const StencilStreams& A, const StencilRun* runs, int count,
                        const float* b, float* x);
  void (*relax_backward)(int lanes, const StencilStreams& A, const StencilRun* runs, int count,
                         const float* b, float* x);
  /// r = b − A·x in runs, and in listed rows.
  void (*residual)(int lanes, const StencilStreams& A, const StencilRun* runs, std::int64_t count,
                   const float* b, const float* x, float* r);
  void (*residual_of_listed)(int lanes, const ListedRows& A, const Selection& rows, const float* b,
                             const float* x, float* r);
  /// y = A·x by row sums, see `StencilMatrix::multiply`; adds to the sums.
  void (*multiply)(int lanes, const StencilStreams& A, const float* row_sums, const StencilRun* runs,
                   std::int64_t count, const ProductVectors& v, ProductSums& sums);
  void (*multiply_listed)(int lanes, const ListedRows& A, const float* row_sums,
                          const Selection& rows, const ProductVectors& v, ProductSums& sums);
  /// (high + low)·X in a run, in double: four columns of X, whose rows are `stride` apart and all of them readable.
  void (*multiply_in_double)(const StencilStreams& high, const StencilStreams& low, const StencilRun& run,
                             const double* X, std::int64_t stride, double* product);
};

MARQUETRY_KERNELS(StencilKernels, stencil_kernels)

}  // namespace mq
