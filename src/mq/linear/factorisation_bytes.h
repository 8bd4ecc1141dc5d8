#pragma once
/// How much memory a factorisation would take.

#include <cstdint>

namespace mq {

/// Bytes that factoring the system of a signal takes at its peak, about: entries of the factor grow
/// like n · log n on surfaces.
double factorisation_bytes(std::int64_t unknowns);

}  // namespace mq
