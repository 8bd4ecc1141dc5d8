#pragma once
/// How strong the noise of a texture is, found in the texture itself.

#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/chart_windows.h"
#include "mq/linear/matrix.h"

namespace mq {

/// The deviation of white noise, per channel: of 8 × 8 blocks within charts, those that hold least in low frequencies
/// (below the ninth of 15 diagonals of their cosine transform, the mean left out), a twentieth of all, are flat but
/// for noise; and of the high frequencies of these the median of the mean square is the noise's, since low and high
/// frequencies of white noise know nothing of each other [ponomarenko2007automatic]. Blocks in which nothing changes,
/// or a third of the values are the least or the greatest of the channel, as they are where a format cut noise off, do
/// not count; 0 where a quarter of all blocks or more are constant, or none is left. Where charts hold fewer than 64
/// blocks, those over seams count too. A ten thousandth of how far values usually lie from their median, or less, is none.
/// Noise that goes with brightness is that where it is weakest, and what a camera or JPEG has smoothed is found too weak:
/// `noise_curve`.
std::vector<double> noise_levels(const ChartWindows& windows, const Signal& psi, const Progress& progress = {});

}  // namespace mq
