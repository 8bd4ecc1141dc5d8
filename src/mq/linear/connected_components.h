#pragma once
/// The parts of a system that do not couple to one another.

#include <vector>

#include "mq/linear/matrix.h"

namespace mq {

/// Numbers the connected components of a symmetric matrix, in the order of their first unknown; one
/// number per unknown. Entries that are 0 join nothing.
std::vector<int> connected_components(const SparseMatrix& A);

/// Per component the sum over its unknowns of the rows of `values`.
Signal component_sums(const std::vector<int>& component, const Signal& values);

}  // namespace mq
