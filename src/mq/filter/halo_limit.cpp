// low, high = means of the least and the greatest of ψ over `reach` steps, over as many steps again
// t = 1 − s²(3 − 2s),  s = (r − c/2) / (c/2) within [0, 1],  r the contrast over `reach` steps, c the given one
// β_t = 1 + (β − 1)·t,  φ' = limited(ψ + φ − φ_t) + φ_t − ψ

#include "mq/filter/halo_limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/solver.h"

namespace mq {

namespace {

/// `combine(a, b)` of every value and those of its neighbours.
template <class Combine>
void widen(const SparseMatrix& A, int channels, std::vector<float>& values, const Combine& combine) {
  std::vector<float> wide(values.size());
  parallel_for(A.rows(), [&](std::int64_t i) {
    float* const to = &wide[std::size_t(i * channels)];
    std::copy_n(&values[std::size_t(i * channels)], channels, to);
    for (int e = A.outerIndexPtr()[i]; e < A.outerIndexPtr()[i + 1]; ++e) {
      const float* const from = &values[std::size_t(A.innerIndexPtr()[e]) * std::size_t(channels)];
      for (int c = 0; c < channels; ++c) to[c] = combine(to[c], from[c]);
    }
  });
  values.swap(wide);
}

/// The mean of every value and those of its neighbours.
void average(const SparseMatrix& A, int channels, std::vector<float>& values) {
  std::vector<float> mean(values.size());
  parallel_for(A.rows(), [&](std::int64_t i) {
    const int first = A.outerIndexPtr()[i], last = A.outerIndexPtr()[i + 1];
    for (int c = 0; c < channels; ++c) {
      const auto at = [&](std::int64_t k) { return double(values[std::size_t(k * channels + c)]); };
      double sum = first == last ? at(i) : 0;
      for (int e = first; e < last; ++e) sum += at(A.innerIndexPtr()[e]);
      mean[std::size_t(i * channels + c)] = float(sum / std::max(1, last - first));
    }
  });
  values.swap(mean);
}

double texture_at(double contrast, double of_edges) {
  const double s = std::clamp(2 * contrast / of_edges - 1, 0.0, 1.0);
  return 1 - s * s * (3 - 2 * s);
}

/// Up to half of the most as it is; beyond, on its way to the most, which it never reaches.
double bent(double excess, double most) {
  const double half = most / 2;
  if (excess <= half) return excess;
  return half > 0 ? half - half * std::expm1(-(excess - half) / half) : 0;
}

}  // namespace

HaloLimit::HaloLimit(const SignalSpace& space, const Signal& psi, const HaloOptions& options,
                     const Progress& progress)
    : channels_(int(psi.cols())), fraction_(options.fraction) {
  require(psi.rows() == space.size() && psi.cols() > 0 && psi.allFinite(),
          fmt::format("a signal of {} × {} was given for {} unknowns, or it is not finite", psi.rows(), psi.cols(),
                      space.size()));
  require(options.fraction >= 0 && std::isfinite(options.fraction) && options.contrast > 0 && options.reach >= 1,
          fmt::format("halos of {} of the contrast, edges from a contrast of {} and a reach of {} were asked for: a "
                      "fraction from 0, a contrast above 0 and a reach from 1 are wanted",
                      options.fraction, options.contrast, options.reach));
  const SparseMatrix A = space.system(0, 1, progress.step("look around", 0.5));
  low_.resize(std::size_t(psi.size()));
  parallel_for(psi.rows(), [&](std::int64_t i) {
    for (int c = 0; c < channels_; ++c) low_[std::size_t(i * channels_ + c)] = float(psi(i, c));
  });
  high_ = low_;
  const Progress widening = progress.step("look around", 0.25), averaging = progress.step("look around", 0.25);
  for (int k = 0; k < options.reach; ++k) {
    widening.at(double(k) / options.reach);
    widen(A, channels_, low_, [](float a, float b) { return std::min(a, b); });
    widen(A, channels_, high_, [](float a, float b) { return std::max(a, b); });
  }
  texture_.resize(std::size_t(psi.rows()));
  parallel_for(psi.rows(), [&](std::int64_t i) {
    double contrast = 0;
    for (int c = 0; c < channels_; ++c) {
      const std::size_t k = std::size_t(i * channels_ + c);
      contrast = std::max(contrast, double(high_[k]) - double(low_[k]));
    }
    texture_[std::size_t(i)] = texture_at(contrast, options.contrast);
  });
  for (int k = 0; k < options.reach; ++k) {
    averaging.at(double(k) / options.reach);
    average(A, channels_, low_);
    average(A, channels_, high_);
  }
}

std::vector<double> HaloLimit::of_texture(std::span<const double> beta) const {
  require(beta.size() == texture_.size(),
          fmt::format("{} modulations were given for {} unknowns", beta.size(), texture_.size()));
  std::vector<double> result(beta.begin(), beta.end());
  for (std::size_t i = 0; i < result.size(); ++i)
    if (result[i] > 1) result[i] = std::lerp(1.0, result[i], texture_[i]);
  return result;
}

double HaloLimit::limited(std::int64_t unknown, int channel, double value, double added) const {
  if (added == 0) return value;
  const std::size_t k = std::size_t(unknown * channels_ + channel);
  const double low = std::min(double(low_[k]), value), high = std::max(double(high_[k]), value);
  const double most = fraction_ * (high - low), sum = value + added;
  if (sum > high) return high + bent(sum - high, most);
  if (sum < low) return low - bent(low - sum, most);
  return sum;
}

Filtered solve_without_halos(const ScreenedPoisson& equation, const SignalSpace& space, const Signal& psi,
                             std::span<const double> beta, const HaloOptions& options, const Progress& progress) {
  if (std::ranges::none_of(beta, [](double b) { return b > 1; })) return equation.solve(psi, beta, progress);
  const HaloLimit limit(space, psi, options, progress.step("look around", 0.1));
  Filtered all = equation.solve(psi, beta, progress.step("solve", 0.45));
  const std::vector<double> of_texture = limit.of_texture(beta);
  if (std::ranges::equal(of_texture, beta)) return all;
  const Filtered texture = equation.solve(psi, of_texture, progress.step("solve", 0.45));
  parallel_for(psi.rows(), [&](std::int64_t i) {
    for (int c = 0; c < int(psi.cols()); ++c) {
      const double was = psi(i, c), of_texture = texture.signal(i, c);
      all.signal(i, c) = limit.limited(i, c, was, all.signal(i, c) - of_texture) + (of_texture - was);
    }
  });
  all.report = worst_of({all.report, texture.report});
  return all;
}

}  // namespace mq
