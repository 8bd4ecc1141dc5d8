#pragma once
/// Texels at seams, chosen so that what hardware shows, bilinear interpolation in every chart for
/// itself, has no seam.

#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/economical_solver.h"

namespace mq {

/// Of agreement at seams against smoothness, per texel of a seam: differences do not show.
inline constexpr double usual_seam_weight = 1000;

/// The space in which `smooth_at_seams` works: bilinear in every chart, the difference d of the two
/// sides of seams punished with `weight`·∫d² ds per texel spacing.
TexelSpaceOptions soft_seams(const Atlas& atlas, double weight = usual_seam_weight);

/// 1 for the unknowns that a lookup on either side of a seam reads.
std::vector<char> seam_texels(const Surface& surface, const Atlas& atlas, const TexelSpace& space);

/// What is as smooth as can be.
enum class Smooth {
  values,  ///< φ itself: what was there does not matter
  change   ///< φ − ψ: detail stays
};

/// The signal φ with new values at the unknowns that are `free` (1): those that minimise
///
///     ∫ |∇φ|² dA + weight/spacing · ∫ d² ds,        or with ∇(φ − ψ),
///
/// where the others stay as they are. The space must have been made with `soft_seams`. Texels that
/// hardly meet the surface are held to their neighbours (`TexelSpace::regularised_system`), and
/// none is left beyond what ψ has around it by more than a quarter of that range (at itself and its
/// neighbours; of smooth values at those that are not free, or else their neighbours): it is
/// brought back and held while the others are solved for again. A component whose texels are all
/// free has no value to start from and stays as it is. Where most texels are near seams, and charts
/// share them, factors are too large: the default goes on by conjugate gradients there. The report
/// is that of the first solution, converged if both did. Throws `InvalidInput` where sizes differ.
Filtered smooth_at_seams(const TexelSpace& space, const Signal& psi, const std::vector<char>& free,
                         Smooth what, const SolverFactory& factory = economical_solver(),
                         const Progress& progress = {});

}  // namespace mq
