#pragma once
/// How the noise of a texture goes with brightness and with frequency, found in the texture itself.

#include <array>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/chart_windows.h"
#include "mq/linear/matrix.h"

namespace mq {

/// The deviation of noise per channel, by brightness, and how neighbours go together. Empty where nothing is known.
struct NoiseCurve {
  std::vector<double> brightness;  ///< rising; in between all is linear
  Signal deviation;                ///< a row for each, a column for each channel; more than 0

  /// Of noise that a camera or JPEG has smoothed, per channel: the variance of each frequency (i, j) of blocks of 8 × 8
  /// texels, row by row, in that of high ones. Empty where noise is white: all would be 1.
  std::vector<std::array<double, 64>> spectrum;

  bool is_empty() const { return brightness.empty(); }

  /// Where a brightness lies among those of the curve: so far from one to the next, `to`; beyond the last more than 1.
  struct Place {
    int to = 0;
    double share = 0;
  };
  Place place_of(double value) const;

  /// The deviation there. Below the least brightness as there; above the greatest it goes on rising if it rose before.
  double at(const Place& place, int channel) const;
  double at(double value, int channel) const { return at(place_of(value), channel); }

  /// Whether the noise of the first channel grows with it, above 0, as that of averaged rays does: at least as fast as
  /// the square root, over a range of twice and more. Values near 0, within one and a half deviations, do not count, as formats
  /// cut noise off there.
  bool grows() const;

  /// How many times as strong noise is from some texels to the next as from one to the next: the root of the mean of
  /// the spectrum for i + j of 3 and 4. 1 where noise is white.
  double smoothed() const;

  /// Of patches of `side` × `side` values of a channel, row by row, where the deviation is 1: symmetric and positive
  /// definite, the mean over where in a block the patch may lie.
  Eigen::MatrixXd covariance(int channel, int side) const;
};

/// Noise that goes with brightness, which is the first channel, as where photons are counted or rays of light are
/// averaged. Blocks are parted into up to 16 classes by their mean brightness, and each class is measured as
/// `noise_levels` measures all of them, for the brightness of its flattest. These must be flat: where low frequencies
/// hold more than high ones by a fifth they are texture, and the class has what those beside it say, at most its own.
/// A channel without flat classes has one deviation.
///
/// Where the first channel has no flat class, noise may have been smoothed. It then falls off with frequency as texture
/// does, but holds as much, within twice, in the first frequencies (i + j up to 2) as in the next, and is nearly the
/// same everywhere. Where it is so `spectrum` and the one deviation are those of the flattest quarter of all blocks, low
/// frequencies divided by what a quarter holds of all where blocks differ by chance alone. Else the curve is empty.
///
/// Costs as much as `noise_levels`.
NoiseCurve noise_curve(const ChartWindows& windows, const Signal& psi, const Progress& progress = {});

}  // namespace mq
