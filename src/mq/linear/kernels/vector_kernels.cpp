#include "mq/linear/kernels/vector_kernels.h"

#include "mq/linear/kernels/vector_lanes.h"

namespace mq::MARQUETRY_FORM {
namespace {

constexpr int N = register_floats;

/// Adds Σ body(i) per lane of four, over the registers that begin at begin, begin + N ...; the same
/// partial sums whatever N is.
template <class Body>
inline void add_sums(std::int64_t begin, std::int64_t end, double* sums, const Body& body) {
  constexpr int registers = partial_sums / N;
  constexpr std::int64_t chunk = 64 * partial_sums;
  for (std::int64_t first = begin; first < end; first += chunk) {
    const std::int64_t stop = first + chunk < end ? first + chunk : end;
    Floats<N> sum[registers] = {};
    for (std::int64_t i = first; i < stop; i += partial_sums)
      for (int n = 0; n < registers; ++n) sum[n] += body(i + n * N);
    for (int i = 0; i < partial_sums; ++i) sums[i % 4] += double(sum[i / N][i % N]);
  }
}

void dot(const float* a, const float* b, std::int64_t begin, std::int64_t end, double* sums) {
  add_sums(begin, end, sums, [&](std::int64_t i) { return load<N>(a + i) * load<N>(b + i); });
}

void next_direction(const float* z, const float* factor, float* p, std::int64_t begin,
                    std::int64_t end) {
  const Floats<N> factors = repeat<4>(factor);
  for (std::int64_t i = begin; i < end; i += N)
    store<N>(p + i, load<N>(z + i) + factors * load<N>(p + i));
}

void reduce(const float* q, const float* factor, float* r, std::int64_t begin, std::int64_t end,
            double* sums) {
  const Floats<N> factors = repeat<4>(factor);
  add_sums(begin, end, sums, [&](std::int64_t i) {
    const Floats<N> left = load<N>(r + i) - factors * load<N>(q + i);
    store<N>(r + i, left);
    return left * left;
  });
}

}  // namespace

const VectorKernels vector_kernels = {dot, next_direction, reduce};

}  // namespace mq::MARQUETRY_FORM
