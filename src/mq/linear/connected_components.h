#pragma once
/// The parts of a system that do not couple to one another.

#include <vector>

#include "mq/linear/matrix.h"

namespace mq {

/// What joins two unknowns: an entry that is not 0, or any that the pattern has, as the values of
/// another matrix may fill it.
enum class Joining { values, pattern };

/// Numbers the connected components of a symmetric matrix, in the order of their first unknown; one
/// number per unknown.
std::vector<int> connected_components(const SparseMatrix& A, Joining by = Joining::values);

/// Per component the sum over its unknowns of the rows of `values`.
Signal component_sums(const std::vector<int>& component, const Signal& values);

}  // namespace mq
