#pragma once
/// Parts of a photograph that show something else than the other photographs of their places: a passer-by, a reflection.

#include <span>
#include <vector>

namespace mq {

/// What a photograph shows of a place beside what photographs agree on there.
struct Compared {
  int cell;  ///< of a lattice over the picture
  double shown, agreed, weight;
};

/// Per cell of a lattice of so many columns and rows, how far what the photograph shows there is to be believed, 0 to 1.
/// With ρ the weighted correlation of shown and agreed over a cell and the eight around it, to the variances of both
/// of which and to their covariance `noise`² is added, so that plain parts go with plain ones and with nothing else, and
/// ρ₀ the median of ρ over the places compared: (ρ/ρ₀ − 0.5) / 0.3, between 0 and 1. Differences of brightness and
/// contrast thus do not matter, and of a photograph that is blurred or off as a whole no part is worse than the others.
/// 1 where less than eight places can be compared.
std::vector<float> parts_that_agree(std::span<const Compared> compared, int columns, int rows, double noise);

}  // namespace mq
