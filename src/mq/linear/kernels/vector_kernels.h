#pragma once
/// Steps of conjugate gradients on whole vectors, in the forms of base/kernel_forms.h. Values
/// begin … end − 1 of vectors in lanes of four (the lanes of one channel are partial sums of it); begin
/// is a multiple of 64, and vectors end in at least 32 zeros, which are read as well.

#include <cstdint>

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

struct VectorKernels {
  /// Adds Σ a·b per lane to sums: in single precision over 1024 values, in double beyond.
  void (*dot)(const float* a, const float* b, std::int64_t begin, std::int64_t end, double* sums);
  /// p = z + factor·p, a factor per lane.
  void (*next_direction)(const float* z, const float* factor, float* p, std::int64_t begin,
                         std::int64_t end);
  /// r −= factor·q; adds Σ r² per lane to sums.
  void (*reduce)(const float* q, const float* factor, float* r, std::int64_t begin, std::int64_t end,
                 double* sums);
};

MARQUETRY_KERNELS(VectorKernels, vector_kernels)

}  // namespace mq
