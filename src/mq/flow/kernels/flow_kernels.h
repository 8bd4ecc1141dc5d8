#pragma once
/// The rows of an `ImageFlowSystem`, in the forms of base/kernel_forms.h.

#include <cstdint>

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

/// A row of the system: what its pixels hold and, with a margin around all planes, the neighbours of
/// the unknowns at u − 1, u + 1, u − width and u + width.
struct FlowRow {
  int width;
  const float *d11, *d12, *d22;
  const float *east, *south, *north;  ///< north: `south` of the row above
  const float *u, *v;
};

struct FlowKernels {
  /// A·x.
  void (*product)(const FlowRow& row, float* out_u, float* out_v);
  /// b − A·x.
  void (*residual)(const FlowRow& row, const float* bu, const float* bv, float* out_u, float* out_v);
  /// What relaxing each pixel by itself would add to x.
  void (*update)(const FlowRow& row, const float* bu, const float* bv, float* out_u, float* out_v);
  /// to += mask·from.
  void (*add_masked)(int count, const float* mask, const float* from, float* to);
  /// to = f·to + g·from.
  void (*combine)(std::int64_t count, float f, float* to, float g, const float* from);
};

MARQUETRY_KERNELS(FlowKernels, flow_kernels)

}  // namespace mq
