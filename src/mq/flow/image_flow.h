#pragma once
/// Optical flow between two images [horn1981determining]: thesis 4.1 to 4.3, with the mesh's
/// preprocessing (4.4.2).

#include <vector>

#include "mq/base/length.h"
#include "mq/base/progress.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"
#include "mq/image/image.h"

namespace mq {

struct ImageFlowOptions {
  /// Table 4.1: φ₀(p) ≈ φ₁(p + X), or φ₀(p − X/2) ≈ φ₁(p + X/2).
  enum class Alignment { forward, halfway } alignment = Alignment::halfway;

  /// Which signals are aligned one after another: only the finest, or each smoothed less than the
  /// one before; there at the resolution of the images, or with a third of the length between
  /// pixels.
  enum class Scales { single, full, hierarchical } scales = Scales::hierarchical;

  /// What p ± X/2 means; forward alignment is straight always.
  FlowPath path = FlowPath::integrated;

  /// ℓ of the first scale; halved from one to the next until `smallest`, which is that of the last
  /// two. Signals are smoothed by a Gaussian of standard deviation ℓ, for the last not at all, and
  /// fields are smooth over about ℓ. Lengths are in pixels where they are in texels or model units,
  /// and percent of the square root of the image's area.
  Length largest = {5, Length::Unit::percent};
  Length smallest = {2, Length::Unit::texels};

  /// ℓ of the field at every scale; 0: that of the scale.
  Length smoothness = {0, Length::Unit::texels};

  /// What is broader than this is taken out of the signals first, as lighting is: φ − Smooth(φ).
  /// 0: nothing is. Near the border Smooth sees other things in the one image than in the other,
  /// so that lighting which stays is better left in.
  Length detail = {0, Length::Unit::texels};

  /// Whether another exposure or contrast of the one image is made good. Not by itself: what moves
  /// into the images or out of them changes their means too.
  ImageLight light = ImageLight::kept;

  /// Weight of the signals' derivatives beside themselves, which change less with the light: the
  /// ratio of their mean squares.
  double gradient_weight = 0;

  /// ϵ of ψ(s²) = 2ϵ²(√(1 + s²/ϵ²) − 1), s² where s is small and 2ϵ|s| where it is large, for
  /// differences (in standard deviations of the scale's signals) and for |∇Y| (a number). 0:
  /// squares.
  double robust_data = 0;
  double robust_smoothness = 0;

  /// How far along Y: at most α*, so that the error falls; or α*, whatever becomes of it.
  enum class StepLength { falling_error, scaled } step_length = StepLength::falling_error;

  int steps = 4;                 ///< corrections at a scale, at most ...
  double least_progress = 0.02;  ///< ... and until one takes off less of the scale's error
  double tolerance = 1e-2;       ///< relative residual of the linear systems
  int max_cycles = 30;

  /// The published normalisation and weights: one correction at each of seven scales, as long as
  /// (4.8) says; smoothing to α = 3·10⁻³ · 4⁻ˡ of unit area (σ = 7.7 % · 2⁻ˡ of √area), lighting
  /// taken out with α = 10⁻⁴, paths straight, and the weight of smoothness the one that 4.6.2 gives
  /// for the triangle basis at 56,000 vertices: 10⁴ times the Frobenius norm of the data matrix
  /// with half the smoothness operator, which is ℓ = 1.9 % of √area at every scale.
  static ImageFlowOptions thesis();
};

/// One scale of the way.
struct ImageFlowLevel {
  double length = 0;             ///< ℓ, pixels
  double deviation = 0;          ///< of the Gaussian that smoothed the signals, pixels
  int width = 0, height = 0;     ///< of the grid it was worked on
  int steps = 0;                 ///< corrections taken
  int cycles = 0;                ///< of multigrid, all corrections
  double scale = 0;              ///< α* of the first correction
  double before = 0, after = 0;  ///< error of this scale's signals, as `ImageFlow::error`
  double seconds = 0;
};

struct ImageFlow {
  Image<float> field;  ///< X: two channels, right and down, pixels
  ImageFlowOptions::Alignment alignment = ImageFlowOptions::Alignment::halfway;
  FlowPath path = FlowPath::integrated;

  /// The error of X = 0 (the linear blend) and after each scale: the mean of ψ_D(φ̃₁ − φ̃₀) over
  /// pixels and channels of the signals after preprocessing, not smoothed, in units of their
  /// variance; a pixel one of whose places lies outside the images counts as in the blend. What is
  /// kept at the end of a scale is the field of least error so far: it never rises.
  std::vector<double> error;
  std::vector<ImageFlowLevel> levels;
};

/// The field that aligns two images, of any number of channels. At each scale corrections Y
/// minimise
///
///     Σ_c ∫ ψ_D(δ_c + ⟨Y, ∇μ_c⟩) + ℓ²Ḡ ∫ ψ_S(|∇Y|),   δ = φ̃₁ − φ̃₀,   Ḡ = (1/A) Σ_c ∫ |∇μ_c|²,
///
/// μ = (φ̃₀ + φ̃₁)/2 halfway and φ̃₁ forward, so that ℓ is a length whatever the resolution and the
/// range of values (equations 4.3 and 4.11; 4.6 solved by `ImageFlowSolver`; ψ by three reweighted
/// systems). Pixels whose place lies outside an image have no data term. X grows by α*Y of equation
/// (4.8), α* ≥ 1 at most 4, or by a half, a quarter, ... of it until the error of the scale's
/// signals falls, over the pixels whose places lie in the images before and after.
///
/// Both images are normalised together, after `detail`, to variance 1 over all channels: c·φ gives
/// the same field for any c > 0. Swapped images give −X, bit for bit, halfway. Throws
/// `InvalidInput` where sizes or channels differ, values are not finite or lengths negative.
ImageFlow image_flow(const Image<float>& source, const Image<float>& target,
                     const ImageFlowOptions& options = {}, const Progress& progress = {});

/// A field that is known, as a flow: `displacement` is what flow files hold (forward alignment, see
/// `forward_displacement`); where it is not known, NaN, it is that of the nearest pixel where it is.
/// Of `options` only what measures counts: `detail`, `light` and `robust_data`. `error` is the
/// linear blend's and that along the field. Throws `InvalidInput` where sizes differ or the flow of
/// no pixel is known, and as `image_flow` does.
ImageFlow known_flow(const Image<float>& source, const Image<float>& target,
                     const Image<float>& displacement, const ImageFlowOptions& options = {},
                     const Progress& progress = {});

/// φ̃₀ and φ̃₁: the images where they meet.
struct AlignedImages {
  Image<float> source, target;
};
AlignedImages aligned(const ImageFlow& flow, const Image<float>& source,
                      const Image<float>& target);

/// The displacement u of the source's pixels, φ₀(p) ≈ φ₁(p + u(p)), which is what flow files hold:
/// halfway Φ_X(p, 1) − p along paths; where these are straight, X at the q with q − X(q)/2 = p, by
/// fixed-point iteration. Forward it is X.
Image<float> forward_displacement(const ImageFlow& flow);

/// Equation (4.26): (1 − t)·Advect(φ₀, −X, t) + t·Advect(φ₁, X, 1 − t), 0 ≤ t ≤ 1. At t = 0 and 1
/// the images themselves. Where one of the two places lies outside its image, the other alone
/// counts. A forward field says where the source's pixels go: it is carried along to time t first
/// (`image_carry.h`), and where nothing of the source comes to, the target alone counts.
Image<float> interpolated(const ImageFlow& flow, const Image<float>& source,
                          const Image<float>& target, double t);

}  // namespace mq
