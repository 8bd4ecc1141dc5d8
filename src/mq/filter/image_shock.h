#pragma once
/// Shock filters on images, by following paths and looking values up at their ends.

#include "mq/filter/shock.h"
#include "mq/image/image.h"
#include "mq/trace/grid_flow.h"

namespace mq {

/// What is taken for the curvature L of the signal: where it is positive, values move to the
/// minimum.
enum class Concavity {
  laplacian,      ///< Δφ: the mean over all directions (Osher and Rudin)
  along_gradient  ///< ⟨Hess φ·∇φ, ∇φ⟩/|∇φ|²: across edges only (thesis (3.5))
};

struct ImageShockOptions {
  /// Thesis 3.3.1 and 3.3.2. With one step all three are the same.
  enum class Method {
    transport,  ///< one field, of the signal at the start
    composed,   ///< a new field in every step; values always from the first image, at the composed
                ///< place
    iterated    ///< a new field in every step; values from the image before, which blurs them each
                ///< time
  } method = Method::transport;
  Concavity concavity = Concavity::along_gradient;
  ShockWeights weights;  ///< pixels²: a Gaussian of variance 2w, which damps as 1/(1 + w·k²) does
  ShockTime time;
  int steps = 1;  ///< of equal length; `transport` takes one
};

/// A sharpened image and how it came about.
struct ShockedImage {
  Image<float> image;
  double rate = 0;  ///< Λ of the first potential, see `potential_rate`; 1/(value²/pixel⁴)
  double time = 0;  ///< pixels, values as they are
  PathCounts counts;
  double path_seconds = 0;  ///< of all steps
};

/// ∂φ/∂t = −⟨X, ∇φ⟩, thesis 3.3, all channels with one field X, constant per cell or triangle:
///
///     along_gradient: X = ∇P, P = ½ Σ_c |∇φ_c|², equation (3.6);   laplacian: X = Σ_c Δφ_c ∇φ_c.
///
/// The image is bilinear between pixel centres: |∇φ|² is its mean over each cell, P the mean of the
/// cells around a pixel, and values are looked up bilinearly. P is linear on the triangles of
/// `GridFlow`, along which −X is followed without steps. Δφ is the sum of differences to four
/// neighbours; on a cell the one nearest to 0 of those at its pixels counts, and 0 where their
/// signs differ, so that edges one cell wide rest.
///
/// In later steps `along_gradient` smooths the signal of the step before and its potential again,
/// as the thesis has it. Δφ = φₙₙ + κ|∇φ| is 0 outside a curved edge, by about the smoothing's
/// variance times its curvature κ: smoothed anew in each step, edges would wander and bulge without
/// end. So `laplacian` smooths the first signal, by both weights together, and carries that along
/// the same paths.
///
/// In one step, pixels that differ from one around them by more than a twentieth of the standard deviation become the mean
/// over paths from eight places in them, so that outlines show no stairs; what a pixel has over the signal at such a place
/// fades over the first pixel of the way.
///
/// No value leaves the range of its channel, for any time. A pixel whose paths rest keeps its
/// values bit for bit. Alpha is a channel like any other. Images with a side of one pixel are as if
/// repeated. Throws `InvalidInput` on values that are not finite, steps below 1, and what
/// `GridFlow` throws.
ShockedImage shock(const Image<float>& image, const ImageShockOptions& options,
                   const Progress& progress = {});

/// The potential above at the pixels, row by row.
std::vector<double> shock_potential(const Image<float>& image, const ShockWeights& weights);

/// Λ of values at pixels: the root mean square of the sum of differences to four neighbours, the
/// border repeated.
double potential_rate(int width, int height, std::span<const double> potential);

}  // namespace mq
