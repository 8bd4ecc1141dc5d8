#pragma once
/// What makes the equation S·φ = b definite where only gradients count.

#include <algorithm>

namespace mq {

/// The weight of the screening where only gradients shall count, in units of 1 / component area.
/// The last pivot of a factorisation is this small beside entries of order 1, and must stay clear
/// of what rounding leaves of several million of them. In a component of few it is smaller, this
/// share of the trace: an iteration in single precision has to see that constants are as good as
/// null, as its rounding errors in them would else be the largest part of what it finds.
inline constexpr double vanishing_weight = 1e-8, vanishing_share = 1e-13;

/// What is added to the diagonal at an unknown with this share of the lumped mass of its component,
/// whose diagonal sums to `trace` (0: no area, and no gradients).
inline double vanishing_screen(double share, double trace) {
  const double most = vanishing_share * trace;
  return share * (most > 0 ? std::min(vanishing_weight, most) : vanishing_weight);
}

}  // namespace mq
