#pragma once
/// A domain in its smallest pieces, each with its own share of the stiffness: for what changes the
/// gradient in a few places only.

#include <functional>
#include <span>

#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"

namespace mq {

/// A triangle, or the part of a cell between texels that lies inside charts or near a seam.
struct Element {
  std::span<const int> own;       ///< unknowns at its corners; none: a piece of a soft seam
  std::span<const int> unknowns;  ///< all it couples: its own and, at seams, those opposite
  std::span<const double>
      stiffness;  ///< ∫ ⟨∇φ_i, ∇φ_j⟩ over it, row by row; positive semidefinite,
                  ///< vanishing on constants; S is the sum over all elements
};

/// Calls visit(element) for those elements whose unknowns do not all have the same label (one per
/// unknown of the space), in a fixed order, on the calling thread. One look at every element.
using MixedElements = std::function<void(std::span<const int> labels,
                                         const std::function<void(const Element&)>& visit)>;

/// Those of a space, which must outlive the result.
MixedElements mixed_elements(const TexelSpace& space);
MixedElements mixed_elements(const VertexSpace& space);

}  // namespace mq
