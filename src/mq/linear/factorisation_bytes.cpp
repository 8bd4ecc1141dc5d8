#include "mq/linear/factorisation_bytes.h"

#include <algorithm>
#include <cmath>

namespace mq {

double factorisation_bytes(std::int64_t unknowns) {
  // Measured: docs/measurements/memory.md.
  constexpr double bytes_per_unknown_and_doubling = 80;
  const double n = double(std::max<std::int64_t>(2, unknowns));
  return bytes_per_unknown_and_doubling * n * std::log2(n);
}

}  // namespace mq
