#pragma once
/// Fireflies of bakes: texels that are no part of the noise, nor of the texture.

#include "mq/filter/chart_windows.h"
#include "mq/filter/noise_curve.h"

namespace mq {

/// Unknowns × channels, luminance first.
using TexelValues = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Texels whose luminance surpasses that of all around them by 6 deviations of noise become the median of these,
/// channel by channel; then once more, for those that stood beside one that was farther out. Texels with fewer than five around
/// them stay. Gives how many there were.
int take_fireflies_off(const ChartWindows& windows, const NoiseCurve& noise, TexelValues& values);

}  // namespace mq
