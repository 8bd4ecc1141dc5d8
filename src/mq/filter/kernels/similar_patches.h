#pragma once
/// What finding similar patches and filtering them together costs most of its time with, in the forms of
/// base/kernel_forms.h.

#include <cstdint>

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

/// Patches are compared with those from so many columns and rows before them on; a square of them in all.
inline constexpr int patch_search_side = 16, patches_before = patch_search_side / 2;

/// At most so many patches are filtered together, of at most so many values each.
inline constexpr int most_patches = 48, most_patch_values = 36;

/// Planes of values, one for each channel, rows one after another.
struct PatchPlanes {
  const float* values;
  std::int64_t plane;  ///< from one channel to the next
  int width;           ///< from one row to the next
  int channels;
};

struct SimilarPatchKernels {
  /// Sums of squared differences between the patch of `side` × `side` values whose left top one is number `at` of a
  /// plane and those of the square of `patch_search_side` around it, rows one after another.
  void (*distances)(const PatchPlanes& planes, int side, std::int64_t at, float* sums);

  /// P ← m + (C − I)·C⁻¹·(P − m) for `count` patches P of noise of deviation 1, row r of value r and
  /// `most_patches` apart: C = cov(Q) + added·I and m = mean(Q) of patches Q that are like them. No value changes by more
  /// than 6, whatever they are.
  void (*shrink)(int rows, int count, float added, const float* like, float* patches);
};

MARQUETRY_KERNELS(SimilarPatchKernels, similar_patch_kernels)

}  // namespace mq
