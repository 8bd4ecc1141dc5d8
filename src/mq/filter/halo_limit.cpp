// low, high = means of the least and the greatest of ψ over `reach` steps, over as many steps again
// u(a) = s²(3 − 2s),  s = r/a − 1 within [0, 1],  r the contrast over `reach` steps
// β ← 1 + (β − 1)·u(threshold),  β_t = 1 + (β − 1)·(1 − u(c/2)),  c the contrast of edges;  φ' = limited(ψ + φ − φ_t) + φ_t − ψ,  φ and φ_t the solutions for both

#include "mq/filter/halo_limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/signal_values.h"

namespace mq {

namespace {

/// Rows of least values and of greatest ones with the sign turned, so that less is wider for all; as many floats, for
/// one channel or up to four, as one loop of a fixed length takes.
int floats_for(int channels) { return channels == 1 ? 2 : 8 * ((2 * channels + 7) / 8); }

/// From 0 at the contrast to 1 at twice it.
double rising_from(double from, double contrast) {
  const double s = std::clamp(contrast / from - 1, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

std::vector<double> above_one(std::span<const double> beta, const std::vector<double>& share) {
  require(beta.size() == share.size(),
          fmt::format("{} modulations were given for {} unknowns", beta.size(), share.size()));
  std::vector<double> result(beta.begin(), beta.end());
  for (std::size_t i = 0; i < result.size(); ++i)
    if (result[i] > 1) result[i] = std::lerp(1.0, result[i], share[i]);
  return result;
}

/// Up to half of the most as it is; beyond, on its way to the most, which it never reaches.
double bent(double excess, double most) {
  const double half = most / 2;
  if (excess <= half) return excess;
  return half > 0 ? half - half * std::expm1(-(excess - half) / half) : 0;
}

}  // namespace

bool sharpens(std::span<const double> beta) {
  return std::ranges::any_of(beta, [](double b) { return b > 1; });
}

/// What combine(A, i, first float of the row) makes of `width` floats of every row at a time.
template <int width, class Combine>
void HaloLimit::for_all_rows(const Couplings& A, int floats, const std::vector<float>& from, std::vector<float>& to,
                  const Combine& combine) {
  parallel_for(std::ssize(A.starts) - 1, [&](std::int64_t i) {
    const auto around = A.columns.subspan(std::size_t(A.starts[i]), std::size_t(A.starts[i + 1] - A.starts[i]));
    for (int first = 0; first < floats; first += width) {
      std::array<float, width> row;
      std::copy_n(&from[std::size_t(i * floats + first)], width, row.data());
      combine(row, around, [&](int j) { return &from[std::size_t(j) * std::size_t(floats) + std::size_t(first)]; });
      std::copy_n(row.data(), width, &to[std::size_t(i * floats + first)]);
    }
  });
}

/// The least of every value and those of its neighbours.
template <int width>
void HaloLimit::widen(const Couplings& A, int floats, std::vector<float>& values, std::vector<float>& room) {
  for_all_rows<width>(A, floats, values, room, [](auto& row, std::span<const int> around, const auto& at) {
    for (const int j : around) {
      const float* const other = at(j);
      for (int k = 0; k < width; ++k) row[k] = std::min(row[k], other[k]);
    }
  });
  values.swap(room);
}

/// The mean of every value and those of its neighbours.
template <int width>
void HaloLimit::average(const Couplings& A, int floats, std::vector<float>& values, std::vector<float>& room) {
  for_all_rows<width>(A, floats, values, room, [](auto& row, std::span<const int> around, const auto& at) {
    if (around.empty()) return;
    std::array<float, width> sum{};
    for (const int j : around) {
      const float* const other = at(j);
      for (int k = 0; k < width; ++k) sum[k] += other[k];
    }
    for (int k = 0; k < width; ++k) row[k] = sum[k] / float(around.size());
  });
  values.swap(room);
}

/// Without the values of the matrix, which take twice the memory.
struct HaloLimit::OwnCouplings {
  std::vector<int> starts, columns;

  /// The matrix is gone when this is made.
  OwnCouplings(const SignalSpace& space, const Progress& progress) {
    const SparseMatrix A = space.system(0, 1, progress);
    starts.assign(A.outerIndexPtr(), A.outerIndexPtr() + A.rows() + 1);
    columns.assign(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros());
  }
};

HaloLimit::HaloLimit(const SignalSpace& space, const Signal& psi, const HaloOptions& options,
                     const Progress& progress)
    : HaloLimit(OwnCouplings(space, progress.step("look around", 0.5)), psi, options,
                progress.step("look around", 0.5)) {}

HaloLimit::HaloLimit(const OwnCouplings& own, const Signal& psi, const HaloOptions& options, const Progress& progress)
    : HaloLimit(Couplings{own.starts, own.columns}, psi, options, SharedUnknowns::alone(), progress) {}

HaloLimit::HaloLimit(const SparseMatrix& A, const Signal& psi, const HaloOptions& options,
                     const SharedUnknowns& shared, const Progress& progress)
    : HaloLimit(Couplings{{A.outerIndexPtr(), std::size_t(A.rows()) + 1}, {A.innerIndexPtr(), std::size_t(A.nonZeros())}},
                psi, options, shared, progress) {}

HaloLimit::HaloLimit(const Couplings& A, const Signal& psi, const HaloOptions& options, const SharedUnknowns& shared,
                     const Progress& progress)
    : channels_(int(psi.cols())), floats_(floats_for(channels_)), fraction_(options.fraction) {
  require(psi.rows() == std::ssize(A.starts) - 1 && psi.cols() > 0 && psi.allFinite(),
          fmt::format("a signal of {} × {} was given for {} unknowns, or it is not finite", psi.rows(), psi.cols(),
                      std::ssize(A.starts) - 1));
  require(options.fraction >= 0 && std::isfinite(options.fraction) && options.contrast > 0 && options.reach >= 1 &&
              options.threshold >= 0 && std::isfinite(options.threshold),
          fmt::format("halos of {} of the contrast, edges from a contrast of {}, a threshold of {} and a reach of {} were "
                      "asked for: a fraction and a threshold from 0, a contrast above 0 and a reach from 1 are wanted",
                      options.fraction, options.contrast, options.threshold, options.reach));
  texture_.resize(std::size_t(psi.rows()));
  ranges_.assign(std::size_t(psi.rows()) * std::size_t(floats_), 0);
  parallel_for(psi.rows(), [&](std::int64_t i) {
    for (int c = 0; c < channels_; ++c) {
      ranges_[std::size_t(i * floats_ + c)] = float(psi(i, c));
      ranges_[std::size_t(i * floats_ + channels_ + c)] = -float(psi(i, c));
    }
  });
  std::vector<float> room(ranges_.size());
  const Progress widening = progress.step("look around", 0.5), averaging = progress.step("look around", 0.5);
  for (int k = 0; k < options.reach; ++k) {
    widening.at(double(k) / options.reach);
    channels_ == 1 ? widen<2>(A, floats_, ranges_, room) : widen<8>(A, floats_, ranges_, room);
    fill_halo(shared);
  }
  if (options.threshold > 0) detail_.resize(texture_.size());
  parallel_for(psi.rows(), [&](std::int64_t i) {
    double contrast = 0;
    for (int c = 0; c < channels_; ++c) contrast = std::max(contrast, high(i, c) - low(i, c));
    texture_[std::size_t(i)] = 1 - rising_from(options.contrast / 2, contrast);
    if (options.threshold > 0) detail_[std::size_t(i)] = rising_from(options.threshold, contrast);
  });
  for (int k = 0; k < options.reach; ++k) {
    averaging.at(double(k) / options.reach);
    channels_ == 1 ? average<2>(A, floats_, ranges_, room) : average<8>(A, floats_, ranges_, room);
    fill_halo(shared);
  }
}

/// Of processes each knows the rows of its own alone.
void HaloLimit::fill_halo(const SharedUnknowns& shared) {
  if (shared.is_alone()) return;
  Vector column(std::ssize(texture_));
  for (int k = 0; k < 2 * channels_; ++k) {
    for (Eigen::Index i = 0; i < column.size(); ++i) column[i] = double(ranges_[std::size_t(i * floats_ + k)]);
    shared.fill_halo(column);
    for (Eigen::Index i = 0; i < column.size(); ++i) ranges_[std::size_t(i * floats_ + k)] = float(column[i]);
  }
}

double HaloLimit::low(std::int64_t unknown, int channel) const {
  return double(ranges_[std::size_t(unknown * floats_ + channel)]);
}

double HaloLimit::high(std::int64_t unknown, int channel) const {
  return -double(ranges_[std::size_t(unknown * floats_ + channels_ + channel)]);
}

std::vector<double> HaloLimit::of_texture(std::span<const double> beta) const { return above_one(beta, texture_); }

std::vector<double> HaloLimit::of_detail(std::span<const double> beta) const {
  return detail_.empty() ? std::vector<double>(beta.begin(), beta.end()) : above_one(beta, detail_);
}

double HaloLimit::limited(std::int64_t unknown, int channel, double value, double added) const {
  if (added == 0) return value;
  const double least = std::min(low(unknown, channel), value), greatest = std::max(high(unknown, channel), value);
  const double most = fraction_ * (greatest - least), sum = value + added;
  if (sum > greatest) return greatest + bent(sum - greatest, most);
  if (sum < least) return least - bent(least - sum, most);
  return sum;
}

SolveInSteps::SolveInSteps(const SignalSpace& space, const Signal& psi, std::span<const double> beta,
                           const HaloLimit* limit)
    : limit_(limit && sharpens(beta) ? limit : nullptr) {
  std::vector<double> all(beta.begin(), beta.end());
  if (all.size() == 1 && limit_) all.assign(std::size_t(psi.rows()), beta.front());
  if (limit_) all = limit_->of_detail(all);
  std::vector<double> of_texture = limit_ ? limit_->of_texture(all) : std::vector<double>();
  if (!limit_ || of_texture == all) {
    all_ = gradient_change(space, psi, all);
    return;
  }
  for (std::vector<double>* change : {&all, &of_texture})
    for (double& b : *change) b -= 1;
  all_ = space.stiffness_times(psi, all);
  texture_ = space.stiffness_times(psi, of_texture);
}

/// A single channel wants no more time for both changes side by side; several want as much, and a fifth more memory than
/// one after the other.
SolveReport SolveInSteps::solve(const ScreenedPoisson& equation, const Progress& progress) {
  const auto correct = [&](Signal& change, const Progress& of) {
    Filtered found = equation.correction(std::exchange(change, {}), of);
    change = std::move(found.signal);
    return std::move(found.report);
  };
  if (texture_.size() == 0) return correct(all_, progress);
  if (all_.cols() > 1) {
    (void)correct(all_, progress.step("solve", 0.5));
    return correct(texture_, progress.step("solve", 0.5));
  }
  Signal both(all_.rows(), 2);
  both << all_, texture_;
  SolveReport report = correct(both, progress);
  all_ = both.leftCols(1), texture_ = both.rightCols(1);
  return report;
}

Signal SolveInSteps::solution(const Signal& psi) && {
  add(psi, all_);
  if (texture_.size() == 0) return std::move(all_);
  parallel_for(psi.rows(), [&](std::int64_t i) {
    for (int c = 0; c < psi.cols(); ++c) {
      const double was = psi(i, c), of_texture = texture_(i, c) + was;
      all_(i, c) = limit_->sharpened(i, c, was, all_(i, c) - was, of_texture - was);
    }
  });
  return std::move(all_);
}

Filtered solve_without_halos(const ScreenedPoisson& equation, const SignalSpace& space, const Signal& psi,
                             std::span<const double> beta, const HaloLimit& limit, const Progress& progress) {
  SolveInSteps steps(space, psi, beta, &limit);
  SolveReport report = steps.solve(equation, progress);
  return {std::move(steps).solution(psi), std::move(report)};
}

Filtered solve_without_halos(const ScreenedPoisson& equation, const SignalSpace& space, const Signal& psi,
                             std::span<const double> beta, const HaloOptions& options, const Progress& progress) {
  if (!sharpens(beta)) return equation.solve(psi, beta, progress);
  const HaloLimit limit(space, psi, options, progress.step("look around", 0.22));
  return solve_without_halos(equation, space, psi, beta, limit, progress.step("solve", 0.78));
}

}  // namespace mq
