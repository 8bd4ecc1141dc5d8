// (C − I)·C⁻¹·D = D − C⁻¹·D, by a Cholesky factorisation of C. Patches lie along the lanes.
#include "mq/filter/kernels/similar_patches.h"

namespace mq::MARQUETRY_FORM {
namespace {

constexpr int lanes = 16;
static_assert(most_patches % lanes == 0 && patch_search_side == lanes);

/// What a pivot may not fall below, of the diagonal: less is what rounding leaves, and would blow up what it divides.
constexpr float least_pivot = 1e-6F;

/// Added to the diagonal, of its greatest value: what rounding makes of C where patches hardly differ but in one way.
constexpr float rounding = 3e-6F;

/// Deviations of noise that no noise surpasses: more is not taken off.
constexpr float most_noise = 6;

void distances(const PatchPlanes& planes, int side, std::int64_t at, float* __restrict sums) {
  for (int dy = 0; dy < patch_search_side; ++dy) {
    float sum[lanes] = {};
    for (int c = 0; c < planes.channels; ++c) {
      const float* const own = planes.values + c * planes.plane + at;
      const float* const other = own + std::int64_t(dy - patches_before) * planes.width - patches_before;
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          const float value = own[std::int64_t(j) * planes.width + i];
          const float* const there = other + std::int64_t(j) * planes.width + i;
          for (int l = 0; l < lanes; ++l) sum[l] += (there[l] - value) * (there[l] - value);
        }
    }
    for (int l = 0; l < lanes; ++l) sums[dy * lanes + l] = sum[l];
  }
}

float product(const float* a, const float* b) {
  float part[lanes] = {};
  for (int k = 0; k < most_patches; k += lanes)
    for (int l = 0; l < lanes; ++l) part[l] += a[k + l] * b[k + l];
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) part[l] += part[l + half];
  return part[0];
}

void subtract(float factor, const float* from, float* __restrict to) {
  for (int k = 0; k < most_patches; ++k) to[k] -= factor * from[k];
}

void scale(float factor, float* to) {
  for (int k = 0; k < most_patches; ++k) to[k] *= factor;
}

/// The lower triangle of C to its Cholesky factor, with the reciprocals of pivots on the diagonal.
void factorise(int rows, float* C) {
  for (int r = 0; r < rows; ++r)
    for (int t = 0; t <= r; ++t) {
      float v = C[r * rows + t];
      for (int u = 0; u < t; ++u) v -= C[r * rows + u] * C[t * rows + u];
      if (t < r)
        C[r * rows + t] = v * C[t * rows + t];
      else
        C[r * rows + r] = 1 / __builtin_sqrtf(v > least_pivot * C[r * rows + r] ? v : least_pivot * C[r * rows + r]);
    }
}

void solve(int rows, const float* L, float* x) {
  for (int r = 0; r < rows; ++r) {
    for (int u = 0; u < r; ++u) subtract(L[r * rows + u], x + u * most_patches, x + r * most_patches);
    scale(L[r * rows + r], x + r * most_patches);
  }
  for (int r = rows - 1; r >= 0; --r) {
    for (int u = r + 1; u < rows; ++u) subtract(L[u * rows + r], x + u * most_patches, x + r * most_patches);
    scale(L[r * rows + r], x + r * most_patches);
  }
}

/// To ± most_noise; 0 for what is no number.
void bound(float* x, int count) {
  for (int k = 0; k < count; ++k) {
    const float low = x[k] > -most_noise ? x[k] : x[k] <= -most_noise ? -most_noise : 0;
    x[k] = low < most_noise ? low : most_noise;
  }
}

void shrink(int rows, int count, float added, const float* like, float* patches) {
  float C[most_patch_values * most_patch_values], x[most_patch_values * most_patches],
      centred[most_patch_values * most_patches];
  for (int r = 0; r < rows; ++r) {
    const float* const q = like + r * most_patches;
    float mean = 0;
    for (int k = 0; k < count; ++k) mean += q[k];
    mean /= float(count);
    for (int k = 0; k < most_patches; ++k) {
      centred[r * most_patches + k] = k < count ? q[k] - mean : 0;
      x[r * most_patches + k] = k < count ? patches[r * most_patches + k] - mean : 0;
    }
  }
  const float share = count > 1 ? 1 / float(count - 1) : 0;
  float greatest = 0;
  for (int r = 0; r < rows; ++r) {
    for (int t = 0; t <= r; ++t)
      C[r * rows + t] = share * product(centred + r * most_patches, centred + t * most_patches);
    C[r * rows + r] += added;
    greatest = greatest > C[r * rows + r] ? greatest : C[r * rows + r];
  }
  for (int r = 0; r < rows; ++r) C[r * rows + r] += rounding * greatest;
  factorise(rows, C);
  solve(rows, C, x);
  bound(x, rows * most_patches);
  for (int r = 0; r < rows; ++r) subtract(1, x + r * most_patches, patches + r * most_patches);
}

}  // namespace

const SimilarPatchKernels similar_patch_kernels = {distances, shrink};

}  // namespace mq::MARQUETRY_FORM
