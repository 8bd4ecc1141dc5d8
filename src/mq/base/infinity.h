#pragma once
/// ∞, as a double.

#include <limits>

namespace mq {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace mq
