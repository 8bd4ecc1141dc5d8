// x(v) is predicted by
//     mean x(n) + g (mean parallelogram - mean x(n))            in the first frame of a group
//     x'(v) + a mean d(n) + b e(v) + c mean e(n)                after a frame x', where d = x - x' and e = x' - x''
// over vertices n before v in its triangles. The weights are the least squares of each frame, in 64ths. They weigh
// constant velocity against standing still, and noise makes b negative: the mean of two frames is nearer to the next
// one than the last is. What is left of x, y and z goes into streams by how much was left of the neighbours.

#include "mq/io/detail/evolving_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "mq/io/detail/symbol_streams.h"

namespace mq {
namespace {

constexpr int motion_contexts = 12;
constexpr int weights_stream = motion_contexts, motion_streams = motion_contexts + 1;
constexpr std::int64_t weight_one = 64;  // weights are in 64ths

using Coordinates = std::vector<std::int64_t>;
using MotionWeights = std::array<std::int64_t, 3>;
using AxisValues = std::array<std::int64_t, 3>;

AxisValues coordinates_at(const Coordinates& all, int v) {
  const std::size_t i = 3 * std::size_t(v);
  return {all[i], all[i + 1], all[i + 2]};
}

/// Sums over the neighbours before a vertex, of d and of e.
struct AroundSums {
  AxisValues moved{}, change{};
  std::int64_t count = 0;
};

AroundSums sums_around(const Coordinates& x, const CodingOrder& order, const MotionState& before, int v) {
  AroundSums sum;
  for (const int n : order.neighbours(v))
    for (std::size_t k = 0, i = 3 * std::size_t(n); k < 3; ++k, ++i) {
      sum.moved[k] = plus(sum.moved[k], minus(x[i], before.coordinates[i]));
      sum.change[k] = plus(sum.change[k], before.change[i]);
    }
  sum.count = std::ssize(order.neighbours(v));
  return sum;
}

/// Codes vertices one after the other, each of which is predicted from those before it.
class MotionCoder {
 public:
  MotionCoder(const CodingOrder& order, const MotionState& before, const MotionWeights& weights)
      : order_(order), before_(before), weights_(weights), left_(std::size_t(order.vertex_count())) {
    if (!before.empty()) moved_.resize(before.coordinates.size());
  }

  /// `residual(context, value, predicted)` codes one value and returns what it differs by.
  template <class Residual>
  void code(Coordinates& x, const Residual& residual) {
    for (int v = 0; v < order_.vertex_count(); ++v) {
      const std::size_t i = 3 * std::size_t(v);
      const int context = left_context(order_, left_, v, motion_contexts);
      const AxisValues predicted =
          before_.empty() ? predicted_in_space<3>(x, order_, v, weights_[0]) : predicted_in_time(v);
      std::uint64_t own = 0;
      for (std::size_t k = 0; k < 3; ++k) own += bounded_left(residual(context, x[i + k], predicted[k]));
      left_[std::size_t(v)] = std::uint32_t(own);
      if (before_.empty()) continue;
      for (std::size_t k = 0; k < 3; ++k)
        moved_[i + k] = plus(times(weights_[0], minus(x[i + k], before_.coordinates[i + k])),
                             times(weights_[2], before_.change[i + k]));
    }
  }

 private:
  AxisValues predicted_in_time(int v) const {
    const AxisValues position = coordinates_at(before_.coordinates, v), change = coordinates_at(before_.change, v);
    AxisValues sum{};
    const auto neighbours = order_.neighbours(v);
    for (const int n : neighbours)
      for (std::size_t k = 0; k < 3; ++k) sum[k] = plus(sum[k], moved_[3 * std::size_t(n) + k]);
    const std::int64_t count = std::max<std::int64_t>(std::ssize(neighbours), 1);
    AxisValues result;
    for (std::size_t k = 0; k < 3; ++k)
      result[k] =
          plus(position[k], nearest_64th(plus(sum[k], times(times(weights_[1], change[k]), count)), count));
    return result;
  }

  const CodingOrder& order_;
  const MotionState& before_;
  const MotionWeights& weights_;
  std::vector<std::uint32_t> left_;
  Coordinates moved_;  ///< a d + c e of each vertex that was coded
};

/// Least squares of `wanted` = Σ weight · feature, sample after sample; large residuals count less in the end.
class WeightFit {
 public:
  void add(const Eigen::Vector3d& features, double wanted) {
    const double left = wanted - features.dot(weights_);
    const double weight = 1 / (1 + std::abs(left));
    matrix_ += weight * features * features.transpose();
    right_ += weight * wanted * features;
  }
  void solve() {
    matrix_.diagonal().array() += 1e-9 * matrix_.trace() + 1e-30;
    weights_ = matrix_.ldlt().solve(right_);
    matrix_.setZero();
    right_.setZero();
  }
  MotionWeights weights() const {
    MotionWeights result{};
    if (!weights_.allFinite()) return result;
    for (int k = 0; k < 3; ++k)
      result[std::size_t(k)] = std::lround(std::clamp(weights_[k], -4.0, 4.0) * double(weight_one));
    return result;
  }

 private:
  Eigen::Matrix3d matrix_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero(), weights_ = Eigen::Vector3d::Zero();
};

MotionWeights best_weights(const Coordinates& x, const CodingOrder& order, const MotionState& before) {
  constexpr int rounds = 3;
  WeightFit fit;
  for (int round = 0; round < rounds; ++round) {
    for (int v = 0; v < order.vertex_count(); ++v) {
      if (order.neighbours(v).empty()) continue;
      const AxisValues own = coordinates_at(x, v);
      if (before.empty()) {
        const AxisValues mean = predicted_in_space<3>(x, order, v, 0),
                         across = predicted_in_space<3>(x, order, v, weight_one);
        for (std::size_t k = 0; k < 3; ++k)
          fit.add({double(across[k] - mean[k]), 0, 0}, double(own[k] - mean[k]));
        continue;
      }
      const AroundSums sum = sums_around(x, order, before, v);
      const AxisValues position = coordinates_at(before.coordinates, v), change = coordinates_at(before.change, v);
      for (std::size_t k = 0; k < 3; ++k)
        fit.add({double(sum.moved[k]) / double(sum.count), double(change[k]),
                 double(sum.change[k]) / double(sum.count)},
                double(own[k] - position[k]));
    }
    fit.solve();
  }
  return fit.weights();
}

}  // namespace

void MotionState::advance(std::vector<std::int64_t> next) {
  change.resize(next.size(), 0);
  if (!coordinates.empty())
    for (std::size_t i = 0; i < next.size(); ++i) change[i] = minus(next[i], coordinates[i]);
  coordinates = std::move(next);
}

MotionState carried_over(const MotionState& before, const std::vector<int>& from,
                         const std::vector<Triangle>& triangles) {
  constexpr int most_rounds = 64;  // rings of new vertices around one that is not
  MotionState after;
  if (before.empty()) return after;
  after.coordinates.assign(3 * from.size(), 0);
  after.change.assign(3 * from.size(), 0);
  std::vector<char> known(from.size(), 0);
  for (std::size_t v = 0; v < from.size(); ++v) {
    if (from[v] < 0) continue;
    known[v] = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      after.coordinates[3 * v + k] = before.coordinates[3 * std::size_t(from[v]) + k];
      after.change[3 * v + k] = before.change[3 * std::size_t(from[v]) + k];
    }
  }
  for (int round = 0; round < most_rounds && std::ranges::find(known, 0) != known.end(); ++round) {
    std::vector<std::int64_t> counts(from.size(), 0);
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k)
        for (const std::size_t step : {1, 2}) {
          const auto v = std::size_t(t[k]), n = std::size_t(t[(k + step) % 3]);
          if (known[v] || known[n] != 1) continue;
          ++counts[v];
          for (std::size_t axis = 0; axis < 3; ++axis)
            after.coordinates[3 * v + axis] = plus(after.coordinates[3 * v + axis], after.coordinates[3 * n + axis]);
        }
    bool found = false;
    for (std::size_t v = 0; v < from.size(); ++v) {
      if (counts[v] == 0) continue;
      known[v] = 1;
      found = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        after.coordinates[3 * v + axis] = nearest_ratio(after.coordinates[3 * v + axis], counts[v]);
    }
    if (!found) break;
  }
  return after;
}

Bytes encode_positions(const std::vector<std::int64_t>& coordinates, const CodingOrder& order,
                       const MotionState& before) {
  SymbolWriter to(motion_streams);
  Coordinates x = coordinates;
  const MotionWeights weights = best_weights(x, order, before);
  for (const std::int64_t weight : weights) to.put_signed(weights_stream, weight);
  MotionCoder(order, before, weights).code(x, [&](int context, std::int64_t value, std::int64_t predicted) {
    const std::int64_t left = minus(value, predicted);
    to.put_signed(context, left);
    return left;
  });
  return to.bytes();
}

std::vector<std::int64_t> decode_positions(ByteView bytes, const CodingOrder& order, const MotionState& before,
                                           const std::string& what) {
  Coordinates x(3 * std::size_t(order.vertex_count()));
  SymbolReader from(bytes, motion_streams, x.size() + 3, what);
  MotionWeights weights{};
  for (std::int64_t& weight : weights) weight = from.get_signed(weights_stream);
  MotionCoder(order, before, weights).code(x, [&](int context, std::int64_t& value, std::int64_t predicted) {
    const std::int64_t left = from.get_signed(context);
    value = plus(predicted, left);
    return left;
  });
  from.end();
  return x;
}

}  // namespace mq
