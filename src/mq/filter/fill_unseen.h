#pragma once
/// What is not known of a signal, filled smoothly over the surface.

#include <span>

#include "mq/fem/space.h"

namespace mq {

/// Gives the unknowns of `space` that are not `known` (0) the values that are harmonic between
/// those that are, (S φ)_t = 0, across charts and seams, nowhere beyond the range of `psi`. Parts
/// of the surface of which nothing is known keep ψ. Throws `InvalidInput` where sizes differ. Costs
/// an assembly of S and a factorisation for what is not known.
Signal fill_unseen(const SignalSpace& space, std::span<const char> known, const Signal& psi);

}  // namespace mq
