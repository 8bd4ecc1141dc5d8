#include "mq/flow/kernels/flow_kernels.h"

namespace mq::MARQUETRY_FORM {
namespace {

enum class Want { product, residual, update };

template <Want want>
inline void row_of(const FlowRow& row, const float* bu, const float* bv, float* __restrict out_u,
                   float* __restrict out_v) {
  const float *u = row.u, *v = row.v;
  const float *a11 = row.d11, *a12 = row.d12, *a22 = row.d22;
  const float *e = row.east, *s = row.south, *n = row.north;
  const std::int64_t width = row.width;
  for (std::int64_t i = 0; i < width; ++i) {
    const float sum = (e[i] + e[i - 1]) + (s[i] + n[i]);
    const float m11 = a11[i] + sum, m22 = a22[i] + sum;
    float ru =
        m11 * u[i] + a12[i] * v[i] -
        ((e[i] * u[i + 1] + e[i - 1] * u[i - 1]) + (s[i] * u[i + width] + n[i] * u[i - width]));
    float rv =
        a12[i] * u[i] + m22 * v[i] -
        ((e[i] * v[i + 1] + e[i - 1] * v[i - 1]) + (s[i] * v[i + width] + n[i] * v[i - width]));
    if constexpr (want != Want::product) {
      ru = bu[i] - ru;
      rv = bv[i] - rv;
    }
    if constexpr (want == Want::update) {
      const float determinant = m11 * m22 - a12[i] * a12[i];
      const float scale = determinant > 0 ? 1 / determinant : 0.0F;
      const float du = (m22 * ru - a12[i] * rv) * scale;
      rv = (m11 * rv - a12[i] * ru) * scale;
      ru = du;
    }
    out_u[i] = ru;
    out_v[i] = rv;
  }
}

void product(const FlowRow& row, float* out_u, float* out_v) {
  row_of<Want::product>(row, nullptr, nullptr, out_u, out_v);
}
void residual(const FlowRow& row, const float* bu, const float* bv, float* out_u, float* out_v) {
  row_of<Want::residual>(row, bu, bv, out_u, out_v);
}
void update(const FlowRow& row, const float* bu, const float* bv, float* out_u, float* out_v) {
  row_of<Want::update>(row, bu, bv, out_u, out_v);
}

void add_masked(int count, const float* mask, const float* from, float* __restrict to) {
  for (int i = 0; i < count; ++i) to[i] += mask[i] * from[i];
}

void combine(std::int64_t count, float f, float* __restrict to, float g, const float* from) {
  for (std::int64_t i = 0; i < count; ++i) to[i] = f * to[i] + g * from[i];
}

}  // namespace

const FlowKernels flow_kernels = {product, residual, update, add_masked, combine};

}  // namespace mq::MARQUETRY_FORM
