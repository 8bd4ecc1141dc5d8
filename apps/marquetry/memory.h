#pragma once
/// How much memory a factorisation would take, and how much there is.

#include <cstdint>

namespace mq::app {

/// Bytes that factoring the system of a signal takes at its peak, about: entries of the factor grow
/// like n · log n on surfaces.
double factorisation_bytes(std::int64_t unknowns);

/// Bytes that can be had without swapping, within the limits set for the process; what is not known
/// limits nothing.
double free_bytes();

}  // namespace mq::app
