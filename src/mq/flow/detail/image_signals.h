#pragma once
/// What optical flow aligns: images without their lighting, at one scale.

#include "mq/image/image.h"

namespace mq {

/// Two signals.
struct SignalPair {
  Image<float> source, target;
};

/// What is done about images taken in different light.
enum class ImageLight {
  kept,     ///< nothing: values that differ are differences
  matched,  ///< each channel of both is brought to the same mean and variance
  evened,   ///< the ratio of both, which changes slowly from place to place, is made good (light_ratio.h)
  doubted   ///< evened where means along the motion show that it is another in each, or matched; else kept
};

/// (φ − Smooth(φ)) / σ of thesis 4.4.2, of both images: Smooth is a Gaussian that damps as
/// 1 / (1 + length²·k²) does at first, σ² the mean square of what remains over all pixels and
/// channels of both, so that neither is made stronger against the other by what only it shows. With
/// length 0 each channel's mean over both is taken off instead. All 0 where the images are constant
/// to six digits. In double precision until the end, so that c·φ gives the same values.
///
/// With light `matched` each channel of each image first loses its own mean and is scaled to the
/// mean of its variances in both, so that a·φ + b in place of one image, a > 0, changes nothing else
/// than σ; a channel that is constant in one of them stays as it is.
SignalPair flow_signals(const Image<float>& source, const Image<float>& target, double length,
                        ImageLight light = ImageLight::kept);

/// The mean over all pixels and channels.
double mean(const Image<float>& signal);

/// The mean square over all pixels and channels.
double mean_square(const Image<float>& signal);

/// The signal smoothed by a Gaussian of standard deviation `deviation` (pixels of `signal`), at
/// another size: each new pixel's mean counts as a part of the smoothing.
Image<float> at_scale(const Image<float>& signal, double deviation, int width, int height);

/// ∂/∂x and ∂/∂y of all channels at a pixel by differences of fourth order, (1, −8, 0, 8, −1)/12,
/// of lower order at the border. The same wherever φ = (a + b)/2 is asked of a and b or of b and a.
struct Slope {
  float x, y;
};
Slope slope(const Image<float>& signal, int x, int y, int channel);

/// The signal with the derivatives of each channel behind it, times `factor`.
Image<float> with_slopes(const Image<float>& signal, double factor);

}  // namespace mq
