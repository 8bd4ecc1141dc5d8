#pragma once
/// Stray texels, as salt-and-pepper noise has them: texels at one of the ends of all values that stand alone.

#include <optional>

#include "mq/filter/chart_windows.h"
#include "mq/linear/matrix.h"

namespace mq {

/// A signal without strays.
struct WithoutStrays {
  int count = 0;                 ///< of the texels that changed
  std::optional<Signal> signal;  ///< none where nothing did
};

/// Texels that noise set to the least or the largest value, channel by channel, become the median of those around them that
/// it did not.
///
/// What surpasses all eight around it by a fifth of the range of values, or falls short of all so, stands alone. Stars,
/// glints, dots and letters do so too. Noise it is if there are both kinds, of each three in ten thousand texels and 16
/// in all, at least; if of either three quarters are within a hundredth of their end; if they lie everywhere alike:
/// as many in each window as chance gives, up to three times its variance; and if not nine tenths of all texels are at
/// the ends, as pictures of dots have it. Then all go that are at an end, in groups of three at most, and differ from
/// the median around them by a tenth of the range.
WithoutStrays without_stray_texels(const ChartWindows& windows, const Signal& psi);

}  // namespace mq
