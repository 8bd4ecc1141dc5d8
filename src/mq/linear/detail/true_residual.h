#pragma once
/// The residual of a scaled system, computed in double from a solution in double.

#include <array>
#include <cstdint>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/linear/detail/scaled_vectors.h"
#include "mq/linear/mixed_cg.h"
#include "mq/linear/stencil_matrix.h"

namespace mq {

/// The functions that are constant on each component, D⁻¹·1 in the scaled system.
class ComponentConstants {
 public:
  using Means = std::vector<std::array<double, 4>>;

  ComponentConstants(const Components& components, const Scaling& scaling)
      : components_(components), scaling_(scaling) {}

  /// Per component the coefficient of its constant in v, 0 where it is not singular; empty if none
  /// is. `value(k, c)` gives v.
  template <class Value>
  Means coefficients(std::int64_t rows, int channels, const Value& value) const {
    if (!components_.any_singular()) return {};
    Means mean(components_.size.size(), {0, 0, 0, 0});
    for (std::int64_t k = 0; k < rows; ++k)
      for (int c = 0; c < channels; ++c) mean[component(k)][c] += value(k, c) / scaling_.row(k);
    for (std::size_t i = 0; i < mean.size(); ++i)
      for (double& m : mean[i]) m *= components_.singular[i] ? 1 / components_.size[i] : 0;
    return mean;
  }

  double at(const Means& mean, std::int64_t k, int c) const {
    return mean[component(k)][c] / scaling_.row(k);
  }

  void remove(LaneVector& v) const {
    const int lanes = v.lanes();
    const std::int64_t rows = v.size() / lanes;
    const Means mean = coefficients(
        rows, lanes, [&](std::int64_t k, int c) { return double(v.data()[k * lanes + c]); });
    if (mean.empty()) return;
    parallel_for(rows, [&](std::int64_t k) {
      for (int c = 0; c < lanes; ++c) v.data()[k * lanes + c] -= float(at(mean, k, c));
    });
  }

 private:
  int component(std::int64_t k) const {
    return components_.component.empty() ? 0 : components_.component[k];
  }

  const Components& components_;
  const Scaling& scaling_;
};

/// Columns first … of B in a unit of their own, scaled, without what it holds of constants on singular components.
class ScaledRightHandSide {
 public:
  ScaledRightHandSide(const Signal& B, int first, int channels, const Scaling& scaling,
                const ComponentConstants& constants, double unit)
      : B_(B), first_(first), channels_(channels), scaling_(scaling), factor_(scaling.common * unit),
        constants_(constants),
        mean_(constants.coefficients(B.rows(), channels, [&](std::int64_t k, int c) {
          return scaled(k, c);
        })) {}

  double operator()(std::int64_t k, int c) const {
    return mean_.empty() ? scaled(k, c) : scaled(k, c) - constants_.at(mean_, k, c);
  }

  template <int channels>
  Double4 row(std::int64_t k) const {
    Double4 row{};
    const double* values = B_.data() + k * B_.cols() + first_;
    for (int c = 0; c < channels; ++c) row[c] = values[c];
    row *= factor_ * scaling_.row(k);
    if (!mean_.empty())
      for (int c = 0; c < channels; ++c) row[c] -= constants_.at(mean_, k, c);
    return row;
  }

  /// r = this − product, rounded, in rows first … first + count − 1; four values of each in `product`, and in r as many
  /// as it has lanes.
  template <int channels>
  void subtract(const double* product, std::int64_t first, int count, float* r) const {
    constexpr int lanes = channels == 1 ? 1 : 4;
    const bool plain = mean_.empty() && scaling_.rows.empty();
    const double* values = B_.data() + first * B_.cols() + first_;
    for (int i = 0; i < count; ++i, values += B_.cols(), product += 4, r += lanes) {
      const Double4 own = plain ? Double4{} : row<channels>(first + i);
      for (int c = 0; c < channels; ++c)
        r[c] = float((plain ? factor_ * values[c] : own[c]) - product[c]);
    }
  }

  /// ‖D⁻¹·‖² of each column.
  Double4 squared_norm() const {
    return parallel_sum(B_.rows(), Double4{}, [&](std::int64_t begin, std::int64_t end) {
      Double4 sum{};
      for (std::int64_t k = begin; k < end; ++k)
        for (int c = 0; c < channels_; ++c) {
          const double value = (*this)(k, c) / scaling_.row(k);
          sum[c] += value * value;
        }
      return sum;
    });
  }

 private:
  double scaled(std::int64_t k, int c) const {
    return factor_ * scaling_.row(k) * B_(k, first_ + c);
  }

  const Signal& B_;
  int first_, channels_;
  const Scaling& scaling_;
  double factor_;
  const ComponentConstants& constants_;
  ComponentConstants::Means mean_;
};

/// B − (high + low)·X for columns first … first + channels − 1 of X, at most 4, in double until it is rounded to r.
void true_residual(const StencilMatrix& high, const StencilMatrix& low, const ScaledRightHandSide& B,
                   const Signal& X, int first, int channels, LaneVector& r);

/// r = B, rounded.
void take_right_hand_side(const ScaledRightHandSide& B, int channels, LaneVector& r);

}  // namespace mq
