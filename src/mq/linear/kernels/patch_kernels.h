#pragma once
/// The updates of a `PatchSmoother`, in the forms of base/kernel_forms.h.

#include "mq/linear/kernels/stencil_kernels.h"

namespace mq {

/// Patch p is the listed rows members[starts[p]] … members[starts[p + 1] − 1], with the inverse of its
/// block, symmetric, row by row, from values[inverses[p]] on.
struct PatchList {
  static constexpr int max_members = 64;
  static constexpr int row_step = 8;
  static constexpr int margin = 16;  ///< values behind the last inverse, which are read and not used

  const int* starts;
  const int* members;
  const std::int64_t* inverses;
  const float* values;
};

/// Some items in their order, or the last of them first.
struct PatchItems {
  Selection some;
  int backward;
};

struct PatchKernels {
  /// x_k += values[p]·(b − A·x)_k for rows members[item], p their position.
  void (*relax_rows)(int lanes, const ListedRows& A, const PatchList& patches, const PatchItems& items,
                     const float* b, float* x);
  /// x_P += (A_PP)⁻¹ (b − A·x)_P for patches.
  void (*relax_patches)(int lanes, const ListedRows& A, const PatchList& patches,
                        const PatchItems& items, const float* b, float* x);
  /// Replaces a symmetric positive definite matrix by its inverse: n rows of `stride` values, n at most
  /// `max_members`, stride a multiple of `row_step`; what lies beyond the n-th of a row is 0.
  void (*invert)(double* a, int n, int stride);
};

MARQUETRY_KERNELS(PatchKernels, patch_kernels)

}  // namespace mq
