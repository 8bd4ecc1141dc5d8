#pragma once
/// Lighting taken out of texture videos (thesis 6.5.2).

#include <functional>
#include <limits>

#include "mq/base/progress.h"
#include "mq/linear/solver.h"
#include "mq/video/temporal_poisson.h"

namespace mq {

struct LightRemovalOptions {
  double weight = 0;        ///< w of gradients, model units squared: alpha · area
  int radius = 10;          ///< frames to either side
  double tolerance = 1e-6;  ///< of each frame's solve
  /// How waves between those that come from the mean and those of the frame are parted: with L = 1/(1 + wλ), half-way at
  /// wλ = 1 in both, the mean's part is
  enum class Crossover {
    gentle,  ///< L, the thesis' equation: 1 − wλ of slow waves and 1/wλ of fast ones
    steep    ///< 3L² − 2L³: 1 − 3(wλ)² and 3/(wλ)², at three solves a frame in place of one
  } crossover = Crossover::gentle;
  /// Frames that are given back; those around them are asked for as far as means reach.
  int first = 0, end = std::numeric_limits<int>::max();
  FrameCosts costs = {};
};

/// The weight of a frame k frames away, of a window of this radius: cubic B-spline, support up to
/// radius + 1 frames away, 2/3 at k = 0.
double window_weight(int k, int radius);

/// What lies in the way of light does so smoothly on the surface, and changes fast: the low
/// frequencies of each frame become those of a mean over time. For each frame
///
///     ψ̄(t) = Σ_k b(k) ψ_{f+k}(t) / Σ_k b(k),   |k| ≤ radius, k in the life of texel t,
///     φ minimises (φ − ψ̄)ᵀ m (φ − ψ̄) + w ∫ |∇φ − ∇ψ|² dA       (thesis, equation 6.1),
///
/// so a wave with eigenvalue λ is that of the mean by 1/(1 + wλ), and the frame's own else. Two octaves
/// beside wλ = 1 a sixteenth is still the other's: light is left there, and what is not tracked exactly is blurred.
/// `Crossover::steep` leaves a hundredth, by ψ + (3L² − 2L³)(ψ̄ − ψ), L·χ what this minimisation makes of a mean χ and a
/// frame 0. A texel
/// lives on as long as it is linked to itself; the window ends with its life, and the weights left
/// are divided by their sum (the thesis takes the subset covered, too). On what does not change the
/// frames come back to the accuracy of the solve; light that changes by ω radians a frame is damped
/// by (sin x / x)⁴ nearly, x = ω (radius + 1) / 4.
///
/// Where frames have a `drift` ψ_{f+k} is looked up where the point of the texel slid to in k frames, in the order of the
/// frames, so that means of what is not tracked exactly stay sharp; each frame is where it was. Where the segment of a
/// mesh changes places keep their distance from their texel.
///
/// Frames are asked for and given back in their order; 2 · radius + 1 are held. What is given back of a part of the frames
/// is what the whole gives, bit for bit, without `drift` and with it. The report's
/// `solve` is that of the frame that took most cycles. Throws as `temporal_poisson` and
/// `ScreenedPoisson`.
TemporalReport remove_lighting(int frames, const FrameSource& load,
                               const std::function<void(int, const TemporalFrame&, Signal)>& store,
                               const LightRemovalOptions& options = {},
                               const Progress& progress = {});

}  // namespace mq
