#include "mq/linear/detail/scaled_vectors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/linear/kernels/vector_kernels.h"

namespace mq {
namespace {

constexpr std::int64_t block_values = 65536;

/// The four sums of all four-value steps; for one channel their total, four times.
Double4 finish(Double4 sum, int lanes) {
  if (lanes == 4) return sum;
  return Double4{} + (sum[0] + sum[1] + sum[2] + sum[3]);
}

/// Σ over the blocks of vectors of `size` values of what body(begin, end, sums) adds to four sums.
template <class Body>
Double4 sum_of_blocks(std::int64_t size, const Body& body) {
  return parallel_sum(size, Double4{}, [&](std::int64_t begin, std::int64_t end) {
    double sums[4] = {};
    body(begin, end, sums);
    return Double4{sums[0], sums[1], sums[2], sums[3]};
  }, block_values);
}

std::array<float, 4> rounded(Double4 v) {
  return {float(v[0]), float(v[1]), float(v[2]), float(v[3])};
}

/// Takes the special rows of a scaling out of v while it lives: they are 0 in v, so that a sum over v
/// leaves them out instead of being drowned by them.
class SpecialRows {
 public:
  SpecialRows(const Scaling& scaling, LaneVector& v) : scaling_(scaling), v_(v) {
    kept_.reserve(scaling.special.size() * v.lanes());
    for (const WeightedIndex& row : scaling.special)
      for (int lane = 0; lane < v.lanes(); ++lane) {
        float& value = at(row.index, lane);
        kept_.push_back(value);
        value = 0;
      }
  }
  ~SpecialRows() {
    std::size_t i = 0;
    for (const WeightedIndex& row : scaling_.special)
      for (int lane = 0; lane < v_.lanes(); ++lane) at(row.index, lane) = kept_[i++];
  }
  SpecialRows(const SpecialRows&) = delete;

  /// Subtracts α times another vector's special rows.
  void subtract(Double4 alpha, const SpecialRows& other) {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      kept_[i] -= float(alpha[int(i) % v_.lanes()]) * other.kept_[i];
  }

  /// Their part of ‖D⁻¹·v‖² per channel.
  Double4 squared() const {
    Double4 sum{};
    std::size_t i = 0;
    for (const WeightedIndex& row : scaling_.special)
      for (int lane = 0; lane < v_.lanes(); ++lane, ++i) {
        const double value = double(kept_[i]) * double(row.weight);
        sum[lane] += value * value;
      }
    return v_.lanes() == 4 ? sum : Double4{} + sum[0];
  }

 private:
  float& at(int row, int lane) { return v_.data()[std::int64_t(row) * v_.lanes() + lane]; }

  const Scaling& scaling_;
  LaneVector& v_;
  std::vector<float> kept_;
};

Double4 size_of(Double4 v) { return v < 0 ? -v : v; }

}  // namespace

Double4 dot(const LaneVector& a, const LaneVector& b) {
  return finish(sum_of_blocks(a.size(), [&](std::int64_t begin, std::int64_t end, double* sums) {
    vector_kernels().dot(a.data(), b.data(), begin, end, sums);
  }), a.lanes());
}

Double4 squared_norm(const Scaling& scaling, LaneVector& r) {
  const SpecialRows special(scaling, r);
  return dot(r, r) + special.squared();
}

void next_direction(const LaneVector& z, Double4 beta, LaneVector& p) {
  const std::array<float, 4> factor = rounded(beta);
  parallel_blocks(z.size(), block_values, [&](std::int64_t begin, std::int64_t end) {
    vector_kernels().next_direction(z.data(), factor.data(), p.data(), begin, end);
  });
}

Double4 reduce_residual(const Scaling& scaling, LaneVector& q, Double4 alpha, LaneVector& r) {
  const SpecialRows of_q(scaling, q);
  SpecialRows of_r(scaling, r);
  of_r.subtract(alpha, of_q);
  const std::array<float, 4> factor = rounded(alpha);
  const Double4 sum =
      sum_of_blocks(r.size(), [&](std::int64_t begin, std::int64_t end, double* sums) {
        vector_kernels().reduce(q.data(), factor.data(), r.data(), begin, end, sums);
      });
  return finish(sum, r.lanes()) + of_r.squared();
}

namespace {

/// Some rows of `add_to_solution`, for a number of channels that the compiler knows.
template <int channels>
LargestValues add_rows(const Scaling& scaling, const float* p, int lanes, Double4 alpha, int first,
                       std::int64_t begin, std::int64_t end, Signal& X) {
  double change[channels] = {}, value[channels] = {};
  const std::int64_t stride = X.cols();
  double* x = X.data() + begin * stride + first;
  for (std::int64_t k = begin; k < end; ++k, x += stride) {
    const bool special = !scaling.rows.empty() && scaling.rows[k] != 1;
    for (int c = 0; c < channels; ++c) {
      const double direction = double(p[k * lanes + c]);
      x[c] += alpha[c] * direction;
      if (special) continue;
      change[c] = std::max(change[c], std::abs(direction));
      value[c] = std::max(value[c], std::abs(x[c]));
    }
  }
  LargestValues found;
  for (int c = 0; c < channels; ++c) found.change[c] = change[c], found.value[c] = value[c];
  return found;
}

}  // namespace

LargestValues add_to_solution(const Scaling& scaling, const LaneVector& p, Double4 alpha, int first,
                              int channels, Signal& X) {
  const auto add = channels == 1   ? add_rows<1>
                   : channels == 2 ? add_rows<2>
                   : channels == 3 ? add_rows<3>
                                   : add_rows<4>;
  LargestValues found =
      parallel_sum(X.rows(), LargestValues{}, [&](std::int64_t begin, std::int64_t end) {
        return add(scaling, p.data(), p.lanes(), alpha, first, begin, end, X);
      }, block_values / 4);
  found.change *= size_of(alpha);
  return found;
}

}  // namespace mq
