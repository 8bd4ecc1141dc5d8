#pragma once
/// Light on a scale on which its noise is the same everywhere.

#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/chart_windows.h"
#include "mq/filter/noise_curve.h"

namespace mq {

/// How the noise of each channel of ψ goes with its own values, where that of all that have some grows
/// (`NoiseCurve::grows`); else nothing. Of channels without noise (`noise` of 0) the curve is empty.
std::vector<NoiseCurve> growing_noise(const ChartWindows& windows, const Signal& psi, const std::vector<double>& noise,
                                      const Progress& progress);

/// z = ln(1 + r v / a) / r per channel, where noise has the deviation a + r v: on this scale that of z is about 1
/// (variance-stabilising, as [anscombe1948transformation] for counts). What is linear in v loses r/2 of the variance of
/// z's noise on the way, which `back` gives again.
class EvenNoise {
 public:
  /// By curves of channels' own noise, empty where there is none. None where a curve is no line, within a third nearly
  /// everywhere, or values are far below 0.
  static std::optional<EvenNoise> of(const std::vector<NoiseCurve>& curves, const Signal& psi);

  Signal there(const Signal& psi) const;

  /// Of z what it is of v, where it has changed from `before`, whose noise had these deviations; else as it was in ψ.
  Signal back(const Signal& z, const Signal& before, const std::vector<double>& noise, const Signal& psi) const;

 private:
  std::vector<double> a_, r_;  ///< per channel; a of 0: it has no noise, and stays
};

}  // namespace mq
