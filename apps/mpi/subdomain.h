#pragma once
/// What a process adds to the matrix of all.

#include <cstdint>
#include <vector>

#include "mq/fem/texel_part.h"
#include "mq/linear/matrix.h"
#include "numbering.h"

namespace mq::shared {

/// Of M + w·S what the elements add whose first texel the process owns: over all processes these matrices sum up to
/// it, and each is positive semidefinite, to rounding.
struct Subdomain {
  std::vector<std::int64_t> numbers;  ///< of the texels of these elements, ascending as in the part; a row each
  SparseMatrix matrix;

  Subdomain() = default;
  /// `A` is the matrix of the part's space, whose pattern is taken.
  Subdomain(const TexelPart& part, const Numbering& numbering, const SparseMatrix& A, double weight);
};

}  // namespace mq::shared
