#pragma once
/// Noise taken off a texture by what its patches have in common, wherever their charts lie.

#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"

namespace mq {

struct PatchDenoiseOptions {
  /// Up to 1 the part of the noise that is taken off; above 1 how many times as strong as it was measured it is
  /// taken for. More than 0.
  double strength = 1;
};

struct PatchDenoised {
  Signal signal;
  std::vector<double> noise;  ///< its deviation, per channel, as `noise_levels` finds it; 0: the channel is as it was
  double smoothed = 1;        ///< as `NoiseCurve::smoothed`
  int fireflies = 0;          ///< texels that stood out far above noise
  int strays = 0;             ///< texels that salt-and-pepper noise had set to an end of all values
};

/// Texture repeats itself, noise does not: each patch P of texels is filtered together with those Q like it around it,
///
///     P' = m + (C − σ²I)·C⁻¹·(P − m),      m = mean(Q), C = cov(Q),
///
/// the best linear estimate of a Gaussian of which the patches are samples (non-local Bayes
/// [lebrun2013nonlocal], after the means of [buades2005nonlocal]). Twice: first channel by channel, patches of 4 × 4
/// chosen by the mean of channels, all of them levelled where they differ by noise alone; then patches of 3 × 3 of all
/// channels at once, chosen in the result of the first, of which C − σ²I is taken too. A texel becomes the mean of
/// what all patches that hold it say. Patches are the 48 nearest of 16 × 16 around; their texels those of the chart
/// and, over its seams, those one gets to by walking on (`ChartWindows`), so that a seam changes little. σ is that
/// of `noise_levels`, per channel, and channels without noise stay as they are. Where `noise_curve` knows more, each
/// place of the patches has the σ of its mean brightness in Q, and noise that was smoothed its covariance instead of
/// σ²I (patches are whitened). Where the noise of all channels grows with their values it is that of averaged rays:
/// all is done on a scale on which it is even (`EvenNoise`), from which nothing comes back below 0, if it is a line of the
/// values; and texels that surpass all around them by 6 σ, fireflies, first become the median of those.
///
/// Stray texels, as salt-and-pepper noise has them, first of all become the median of those around them: texels at either
/// end of a channel's values that stand alone, where there are many of both kinds and they lie everywhere alike, as stars,
/// glints and print do not. They go whatever the strength.
///
/// A signal without noise comes back bit for bit. The mean of each component of the surface is kept (of light nearly, on
/// the even scale and but for fireflies). Texels within four of the surface's own boundary on both sides, in strips, have
/// no patches and stay. Costs about 12 µs a texel of three channels on one core, and memory for three signals in single
/// precision.
///
/// Surface and atlas are those of the space. Throws `InvalidInput` where the signal does not fit or is not finite, or
/// the strength is not more than 0.
PatchDenoised denoise_by_patches(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                                 const Signal& psi, const PatchDenoiseOptions& options = {},
                                 const Progress& progress = {});

}  // namespace mq
