#pragma once
/// A signal made of values that are known at points of its domain: a picture resampled to other
/// texels, what one surface shows on another.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/filter/screened_poisson.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// Samples s of value f_s, each standing for the area w_s around its point x_s. The signal is
/// either the mean of what each unknown's function covers,
///
///     φ̄_i = Σ_s w_s φ_i(x_s) f_s / Σ_s w_s φ_i(x_s) ,
///
/// which shows nothing finer than its texels and nothing beyond the values, or the one that shows
/// the samples best,
///
///     argmin_φ  Σ_s w_s (Σ_i φ_i φ_i(x_s) − f_s)²  +  η Σ_i m_i (φ_i − φ̄_i)² ,   η = 1e-3 ,
///
/// m_i the area of the function (at least 1e-6 of the mean one): a quadrature of the L² projection,
/// kept definite where an unknown is seen at its rim alone. Of samples of a smooth function both
/// are off by O(h²), h the spacing of the unknowns; the second gives back a signal of the space but
/// for η. It may go beyond the values by a few per cent of a step.
class SampleFit {
 public:
  /// Assembles a mass matrix for its pattern. The space must stay.
  SampleFit(const SignalSpace& space, int channels, const Progress& progress = {});

  /// Points that take part in the space, the areas that they stand for (model units squared), a row
  /// of values each; those not `seen` (0) count as area of which nothing is known. Their order
  /// decides the last bits of sums, the number of threads does not. Throws `InvalidInput` where
  /// sizes differ.
  void add(std::span<const SurfacePoint> points, std::span<const double> areas,
           const Signal& values, std::span<const char> seen);

  /// 1 for the unknowns of whose sampled area at least a tenth was seen.
  std::vector<char> known() const;

  /// How many are not known, but for those that hardly meet the domain.
  std::int64_t unseen() const;

  /// φ̄; 0 where nothing is known.
  Signal mean() const;

  /// The best fit, by conjugate gradients to a relative residual of 1e-4; 0 where nothing is known.
  Filtered least_squares(const Progress& progress = {}) const;

 private:
  Signal seen_means() const;

  const SignalSpace& space_;
  SparseMatrix normal_;  ///< Σ_s w_s φ_i(x_s) φ_j(x_s)
  Vector mass_;          ///< m
  Signal moments_;       ///< Σ_s w_s φ_i(x_s) f_s
  Vector seen_, sampled_;
};

}  // namespace mq
