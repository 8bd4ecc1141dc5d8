#pragma once
/// Noise taken off, edges kept: smoothing that stops where the signal or a guide changes fast.

#include <limits>
#include <vector>

#include "mq/filter/screened_poisson.h"

namespace mq {

/// A signal of the space, of any number of channels, whose edges are kept in another: normals,
/// albedo.
struct Guide {
  Signal values;
  double edge = 0.05;  ///< change from one unknown to the next at which values spread half as well
};

struct DenoiseOptions {
  double weight = 0;  ///< square of the length that values spread over where there is no edge
  /// The same as `Guide::edge` of the signal itself, as the step before left it; infinite: its own
  /// edges do not count.
  double edge = std::numeric_limits<double>::infinity();
  int steps = 1;  ///< solutions with the edges of the one before, after a first one; where only
                  ///< guides count there is one in all
};

/// Minimises, for all channels with one conductivity, so that they keep their edges together,
///
///     ∫ (φ − ψ)² dA + w ∫ c |∇φ|² dA,      c = Π 1 / (1 + (h̄ |∇g| / edge)²)
///
/// over all guides g and φ itself (Perona and Malik [perona1990scale]; lagged: c is of the φ
/// before). h̄ is the mean spacing of unknowns, |∇g| the root mean square over an element, summed
/// over channels. A first solution, which takes no edges from the signal, spreads over a spacing
/// and a half only: what it leaves are the edges of the next.
///
/// A constant comes back as it is, and the mean of each component and channel. Values may be of any
/// range (HDR). Costs a set-up and a solve of the screened Poisson equation per step. Throws
/// `InvalidInput` on an edge that is not positive, fewer steps than 1, or guides that do not fit.
Filtered denoise(const SignalSpace& space, const Signal& psi, const std::vector<Guide>& guides,
                 const DenoiseOptions& options, const SolverFactory& factory = {},
                 const Progress& progress = {});

}  // namespace mq
