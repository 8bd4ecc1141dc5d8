#pragma once
/// Transfers between levels, in the forms of base/kernel_forms.h. Vectors are rows × lanes (1, 4 or 8).

#include <cstdint>

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

struct WeightedIndex {
  int index = 0;
  float weight = 0;
};

/// Where a fine unknown of a grid lies: coarse nodes `upper` and, if between two columns, upper + 1;
/// if between two rows, also `lower` and, if between two columns, lower + 1.
struct GridParents {
  std::uint32_t upper : 29 = 0;
  std::uint32_t between_columns : 1 = 0;
  std::uint32_t between_rows : 1 = 0;
  std::uint32_t moved : 1 = 0;  ///< reads other nodes than these say
  int lower = 0;
};

/// The up to 3 × 3 fine unknowns that a coarse node of a grid reaches: in row i (above, on, below) those
/// flagged left, on and right of the node's column. They are unknowns centre − 1, centre and
/// centre or, where flagged so, centre + 1.
struct GridChildren {
  static constexpr std::uint8_t some_moved = 16;  ///< of the first: some read other nodes

  int centre[3] = {0, 0, 0};
  std::uint8_t flags[3] = {0, 0, 0};  ///< 1: left, 2: on, 4: right, 8: it is centre + 1
};

/// Rows rows[begin … end − 1], or, where there are none, begin … end − 1 themselves.
struct TransferRows {
  const int* rows;
  std::int64_t begin, end;
};

struct TransferKernels {
  /// to_i = Σ_e w_e from_e over the entries starts[i] … starts[i + 1] − 1 of row i, or added to it.
  void (*sums)(int lanes, const int* starts, const WeightedIndex* entries, const TransferRows& rows,
               const float* from, float* to);
  void (*add_sums)(int lanes, const int* starts, const WeightedIndex* entries,
                   const TransferRows& rows, const float* from, float* to);
  void (*sums_in_double)(int lanes, const int* starts, const WeightedIndex* entries,
                         const TransferRows& rows, const double* from, double* to);
  void (*add_sums_in_double)(int lanes, const int* starts, const WeightedIndex* entries,
                             const TransferRows& rows, const double* from, double* to);
  /// b = Pᵀ·r and x += P·y of bilinear interpolation, as if nothing were moved.
  void (*restrict_grid)(int lanes, const GridChildren* children, const TransferRows& rows,
                        const float* r, float* b);
  void (*prolongate_grid)(int lanes, const GridParents* parents, const TransferRows& rows,
                          const float* y, float* x);
};

MARQUETRY_KERNELS(TransferKernels, transfer_kernels)

}  // namespace mq
