#pragma once
/// Noise taken off, edges kept: smoothing that stops where the signal or a guide changes fast.

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "mq/base/length.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {

/// A signal of the space, of any number of channels, whose edges are kept in another: normals,
/// albedo.
struct Guide {
  Signal values;
  double edge = 0.05;  ///< change from one unknown to the next at which values spread half as well
};

/// Over which length values spread where nobody says, in spacings of unknowns: enough for noise from
/// one to the next, and little enough for letters.
inline constexpr Length usual_denoise_length{4, Length::Unit::texels};

/// The square of that; where there are no texels, of distances of neighbouring unknowns.
double usual_denoise_weight(const SignalSpace& space);

struct DenoiseOptions {
  double weight = 0;  ///< square of the length that values spread over where there is no edge
  /// The same as `Guide::edge` of the signal itself, as the step before left it; infinite: its own
  /// edges do not count; none: as `measured_edge` finds it.
  std::optional<double> edge = {};
  double strength = 1;  ///< up to 1 the part of the change that is made; above 1 `measured_edge` is so much larger
  int steps = 1;  ///< solutions with the edges of the one before, after a first one; where only
                  ///< guides count there is one in all
};

struct Denoised : Filtered {
  double edge = 0;  ///< that the signal's own edges were kept by
};

/// The edge that parts noise from detail, of a signal from which noise from one unknown to the next
/// is nearly gone: the lower quartile of h̄ |∇φ| over elements that hold some of the surface, which is what noise leaves where there
/// is nothing but noise. 0 where a quarter of the signal is constant: then there is no
/// noise. The quartile of noise of deviation σ in each of n channels that the first step of
/// `denoise` leaves is about 0.12 σ √n. Detail that covers more than three quarters of the surface
/// counts as noise.
double measured_edge(const SignalSpace& space, const Signal& smoothed);

/// What `denoise` is made of, for those that hold a part of the surface each. All go by h̄, the mean spacing of unknowns.
namespace denoising {

/// h̄ of a space of this scale with so many unknowns.
double spacing(const SurfaceScale& scale, std::int64_t unknowns);

/// The weight of the first, slight solution, where the others have this one.
double first_weight(double weight, double spacing);

/// What that may leave of its residual: edges are looked for in it, and noise a hundredth as strong is none. Where texels
/// are much stretched it stops before that, with noise of a few texels gone.
ConjugateGradientOptions first_stop();

/// The norms of the gradients of those elements that hold some of the surface and that `counts` is 1 for (empty: all).
std::vector<float> surface_gradients(const SignalSpace& space, const Signal& smoothed, std::span<const char> counts = {});

/// `measured_edge` where the norms of the gradients have this quartile and largest value.
double edge_from(float quartile, float largest, double spacing);

/// Multiplies the conductivity of each element by 1 / (1 + (h̄ |∇g| / edge)²), but leaves a trace of it.
void stop_at_edges(std::span<const float> gradient_norms, double spacing, double edge, std::vector<float>& conductivity);

}  // namespace denoising

/// Minimises, for all channels with one conductivity, so that they keep their edges together,
///
///     ∫ (φ − ψ)² dA + w ∫ c |∇φ|² dA,      c = Π 1 / (1 + (h̄ |∇g| / edge)²)
///
/// over all guides g and φ itself (Perona and Malik [perona1990scale]; lagged: c is of the φ
/// before). h̄ is the mean spacing of unknowns, |∇g| the root mean square over an element, summed
/// over channels. A first solution, which takes no edges from the signal, spreads over a spacing
/// and a half only: what it leaves are the edges of the next. A signal without noise, edge 0, comes
/// back as it is.
///
/// A constant comes back as it is, and the mean of each component and channel. Values may be of any
/// range (HDR). Costs a set-up and a solve of the screened Poisson equation per step. Throws
/// `InvalidInput` on an edge that is not positive, fewer steps than 1, or guides that do not fit.
Denoised denoise(const SignalSpace& space, const Signal& psi, const std::vector<Guide>& guides,
                 const DenoiseOptions& options, const SolverFactory& factory = {},
                 const Progress& progress = {});

}  // namespace mq
