#pragma once
/// Levels: one number for each region and channel that takes most of the steps between regions out, before what is
/// left of them is spread (stitch.h).
///
/// Let m_ab be the median, over the pairs of neighbouring unknowns i of region a and j of region b, of ψ_j − ψ_i,
/// weighted by −S_ij. The levels o minimise
///
///     Σ_ab (o_b − o_a + m_ab)² / σ_ab² + Σ_a o_a² / s²,
///
/// σ_ab how sure the median is: the spread of the differences (1.4826 times their median absolute deviation, or that of
/// all borders where it is less) over the root of the border's length in stretches of `border_stretch` pairs, as
/// neighbouring pairs see the same things; s twice the root mean square of all m_ab. So a long border along which the same step is
/// seen everywhere has its way, and one where two photographs show different things has little. A median, not a mean:
/// what stands before one side of a border only is not light.
///
/// A gradient-domain solve that spreads corrections over the whole surface finds levels too, but from means, and
/// believes all borders alike: over a row of photographs its errors add up.

#include <span>

#include "mq/fem/space.h"

namespace mq {

/// How many pairs of a border count as one that is independent.
inline constexpr double border_stretch = 8;

/// A row for each label from 0 to the largest, zero for those that have no neighbour; of mean 0 over the unknowns
/// (weighted by `mass`) of regions that border on each other, directly or by others. Unknowns that are `unseen` have
/// no region. In units of ψ. Throws `InvalidInput` where sizes differ.
Signal region_levels(const SparseMatrix& stiffness, const Vector& mass, const Signal& psi,
                     std::span<const int> labels);

/// ψ and the levels of the regions.
Signal with_levels(const Signal& psi, const Signal& levels, std::span<const int> labels);

}  // namespace mq
