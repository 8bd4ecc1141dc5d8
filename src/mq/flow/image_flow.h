#pragma once
/// Optical flow between two images [horn1981determining]: thesis 4.1 to 4.3, with the mesh's
/// preprocessing (4.4.2).

#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/flow/flow_options.h"
#include "mq/flow/light_ratio.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"
#include "mq/image/image.h"

namespace mq {

/// What is done where the way from large to small scales leaves pixels that do not fit.
enum class FlowSearch {
  none,
  far  ///< motions up to 0.3 of the images' sides are searched for, beside that field, and pixels choose
};

struct ImageFlowOptions : FlowOptions {
  /// Lengths are in pixels where they are in texels or model units, and percent of the square root
  /// of the image's area. ℓ is halved until `smallest`, which is that of the last two levels; signals
  /// are smoothed by a Gaussian of standard deviation ℓ. Near the border light is taken for other
  /// things in the one image than in the other, so that what stays is better left in: no `detail`.
  ImageFlowOptions()
      : FlowOptions{.largest = {5, Length::Unit::percent},
                    .smallest = {2, Length::Unit::texels},
                    .steps = 4,
                    .least_gain = 1 - 0.98 * 0.98,
                    .tolerance = 1e-2} {}

  /// Which signals are aligned one after another: only the finest, or each smoothed less than the
  /// one before; there at the resolution of the images, or with a third of the length between
  /// pixels.
  enum class Scales { single, full, hierarchical } scales = Scales::hierarchical;

  /// What p ± X/2 means; forward alignment is straight always.
  FlowPath path = FlowPath::integrated;

  /// ℓ of the field at every scale; 0: that of the scale.
  Length smoothness = {0, Length::Unit::texels};

  /// Whether another exposure or contrast of the one image is made good. Not before something says so: what moves
  /// into the images or out of them changes their means too. `doubted` is for where far motions are searched for, and
  /// `kept` elsewhere; `evened` is of no negative values, and refused elsewhere.
  ImageLight light = ImageLight::doubted;

  /// Small things beside others that move far, as photographs have: halfway and with scales `hierarchical` only.
  FlowSearch search = FlowSearch::far;

  int max_cycles = 30;  ///< of the linear solver

  /// The published normalisation and weights: one correction at each of seven scales, as long as
  /// (4.8) says; smoothing to α = 3·10⁻³ · 4⁻ˡ of unit area (σ = 7.7 % · 2⁻ˡ of √area), lighting
  /// taken out with α = 10⁻⁴, paths straight, and the weight of smoothness the one that 4.6.2 gives
  /// for the triangle basis at 56,000 vertices: 10⁴ times the Frobenius norm of the data matrix
  /// with half the smoothness operator, which is ℓ = 1.9 % of √area at every scale.
  static ImageFlowOptions thesis();
};

/// One scale of the way; the last one is that of the search, without corrections of its own, where its field is kept.
struct ImageFlowLevel : FlowLevel {
  double deviation = 0;          ///< of the Gaussian that smoothed the signals, pixels
  int width = 0, height = 0;     ///< of the grid it was worked on
  double scale = 0;              ///< α* of the first correction
  double before = 0, after = 0;  ///< error of this scale's signals, as `ImageFlow::error`
};

struct ImageFlow {
  Image<float> field;  ///< X: two channels, right and down, pixels
  FlowAlignment alignment = FlowAlignment::halfway;
  FlowPath path = FlowPath::integrated;

  /// The error of X = 0 (the linear blend) and after each scale: the mean of ψ_D(φ̃₁ − φ̃₀) over
  /// pixels and channels of the signals after preprocessing, not smoothed, in units of their
  /// variance; a pixel one of whose places lies outside the images counts as in the blend. What is
  /// kept at the end of a scale is the field of least error so far: it never rises.
  std::vector<double> error;
  std::vector<ImageFlowLevel> levels;

  /// How the images fit each other along X, where far motions are searched for.
  struct Fit {
    /// Whether X is that of the search: it jumps from pixel to pixel, and pictures between show each pixel from where
    /// it is seen. Its `error` is the mean over the pixels that are seen in both images.
    bool torn = false;
    Image<float> misfit;  ///< halfway, one channel: 0 alike, 1 unlike, the mean around each pixel
    double unfit = 0;     ///< the share of pixels halfway that nothing fits: pictures between show the blend there
    /// The share of pixels with detail whose detail is alike along X, and how X bends, as `DetailMatch` (detail_match.h).
    double alike = 1, bend = 0;
    /// Whether the two seem to show different things: nothing fits more than 15 % of the pixels, and along X more than
    /// 30 % of what they differ in is left; or less than 35 % of detail is alike along an X that bends by more than 0.3.
    /// Pictures between are the blend then.
    bool unrelated = false;
    /// Whether parts of pictures between may be mangled, as those of a thing that turns: less than 90 % of detail is alike,
    /// and X bends by more than 0.15.
    bool strained = false;
    Length detail{};      ///< how the signals were prepared
    ImageLight light = ImageLight::kept;  ///< or `matched`, or `evened` by the `ratio`
    LightRatio ratio{};
  };
  std::optional<Fit> fit;
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
/// Motions that are far, and small things beside them, are then searched for (`torn_field`) if a hundredth of the
/// pixels are unlike along X, and that field, which is straight, is kept if the images fit a third better along it and
/// its error is less (after [kroeger2016dis], [brox2011ldof], [lempitsky2008fusionflow]). It takes about as long as
/// all before. Where light is `doubted`, means along X tell how much more of it one image has (`light_ratio`). More than a
/// hundredth is another light, and so is suspected where nothing fits a twentieth of the pixels or a fifth of the error is
/// left: then the field is found that aligns what is finer than 2 % of √area, matched, which light hardly changes;
/// the ratio along that is made good, and all is done once more. It is kept if the images fit a third better so. Else
/// the same with light matched, where much is left; images of negative values are matched only.
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
/// fixed-point iteration; where X jumps that of the pixel halfway that comes from there and fits best. Forward it is X.
Image<float> forward_displacement(const ImageFlow& flow);

/// Equation (4.26): (1 − t)·Advect(φ₀, −X, t) + t·Advect(φ₁, X, 1 − t), 0 ≤ t ≤ 1. At t = 0 and 1
/// the images themselves. Where one of the two places lies outside its image, the other alone
/// counts. A forward field says where the source's pixels go: it is carried along to time t first
/// (`forward_warp.h`), and where nothing of the source comes to, the target alone counts. So is one that jumps; where
/// what moves otherwise hides a pixel's place in one image the other alone counts. With `fit`, what is hidden in both
/// or unlike in both, and no less so than it lies, is blended without moving; all is where the two are `unrelated`.
Image<float> interpolated(const ImageFlow& flow, const Image<float>& source,
                          const Image<float>& target, double t);

}  // namespace mq
