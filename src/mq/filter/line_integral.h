#pragma once
/// A vector field made visible: noise that is spread along its lines (line integral convolution;
/// Cabral and Leedom [cabral1993imaging], here by diffusion as in thesis 5.9.4).
///
/// 1. `solid_noise` at the unknowns, the same however the surface is cut into charts.
/// 2. `smooth` on a space with the metric of `texel_metrics_across` or `shapes_across`: values spread
///    over √w along a field Y and over √w / √(1 + κ² |Y|²) across it.
/// 3. `sharpen` on the surface's own space, which brings the contrast between lines back.
/// 4. `evened`: what is broader than lines goes, and they are as clear everywhere.
/// 5. `with_contrast`.

#include <cstdint>
#include <functional>
#include <span>

#include "mq/filter/screened_poisson.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Noise in [0, 1] at places in space: uniform values on a grid of this spacing, interpolated
/// linearly. One column. Throws `InvalidInput` when the spacing is not positive.
Signal solid_noise(std::span<const Vector3> places, double spacing, std::uint64_t seed = 0);

struct LineIntegralOptions {
  double weight = 0;          ///< square of the length that values spread over along the field
  double sharpen_weight = 0;  ///< thesis: 10⁻⁴ of the area; 0: not sharpened
  double sharpen_beta = 100;
  double even_weight = 0;  ///< of `evened`; 0: broad bands and faint lines stay
};

/// The grain of noise for lines that are fine, and that even texels can show: a quarter of a per cent of √area, or twice
/// the mean spacing of texels, whichever is larger.
double finest_grain(const SurfaceScale& scale);

/// That, with the mean spacing of unknowns; or the spacing that a fifth of the surface exceeds, where that is larger, so
/// that texels, or vertices, can show lines nearly everywhere. The spacing of an unknown is the root of its lumped mass.
double usual_grain(const SignalSpace& space);

/// The lines of a field, values in no particular range, and how both equations were solved.
struct LineIntegral {
  Signal signal;
  SolveReport spread, sharpen;
};

/// Lines φ without what is broader than they are, and equally clear everywhere:
///
///     (φ − m) / √v,    m = A φ,    v = A (φ − m)²,    (M + w·S) A = M,
///
/// so that means over a few √w are 0 and mean squares 1; where v is less than a hundredth of its mean they stay fainter, as
/// lines do that hardly are any. Times a number it is the same. A constant becomes 0. `means` is the equation of weight w.
Signal evened(const ScreenedPoisson& means, const Signal& lines, const Progress& progress = {});

/// Steps 2 to 4. `across` and `surface` are spaces of the same unknowns, with the metric across
/// the field and without. A constant comes back as it is.
LineIntegral line_integral(const SignalSpace& across, const SignalSpace& surface,
                           const Signal& noise, const LineIntegralOptions& options,
                           const SolverFactory& factory, const Progress& progress = {});

/// What the lines are before they are whole, for somebody who looks on: `shown(k, φ_k)` for the
/// noise, φ_0, and what 1, 2, 4, ... up to `steps` steps of plain conjugate gradients make of it on
/// the way to the φ of step 2. With each step values go one unknown further. Nothing of it is in
/// the result of `line_integral`; takes a matrix of its own while it lasts.
void watch_lines_form(const SignalSpace& across, const Signal& noise, double weight, int steps,
                      const std::function<void(int, const Signal&)>& shown,
                      const Progress& progress = {});

/// Lines over a picture: each colour goes up to 0.4 of the way to white, and of that to black, by the grey of the
/// lines from 1 to 0. So nothing leaves the range, and lines show on black and on white too; light above 1 only
/// darkens. Columns of `colours` from `channels` on, alpha, stay.
Signal lines_over(const Signal& colours, const Signal& grey, int channels);

/// Shifted and scaled such that the mean is ½ and `deviations` standard deviations lie between
/// there and 0 or 1, then cut to [0, 1]. A constant becomes ½. Unknowns weigh alike.
Signal with_contrast(const Signal& signal, double deviations = 2);

}  // namespace mq
