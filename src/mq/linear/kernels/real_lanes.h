#pragma once
/// The channels of one unknown as a short vector, in either precision. Included by kernels
/// only (base/kernel_forms.h); those in single precision alone have more in vector_lanes.h.

#include <cstdint>
#include <cstring>

namespace mq::MARQUETRY_FORM {

template <class Real, int lanes>
struct RealLanes {
  typedef Real Type __attribute__((vector_size(lanes * sizeof(Real))));
};
template <class Real>
struct RealLanes<Real, 1> {
  using Type = Real;
};

/// The lanes of row i of v.
template <int lanes, class Real>
inline typename RealLanes<Real, lanes>::Type row_of(const Real* v, std::int64_t i) {
  typename RealLanes<Real, lanes>::Type row;
  std::memcpy(&row, v + i * lanes, sizeof row);
  return row;
}

template <int lanes, class Real>
inline void set_row(Real* v, std::int64_t i, typename RealLanes<Real, lanes>::Type row) {
  std::memcpy(v + i * lanes, &row, sizeof row);
}

}  // namespace mq::MARQUETRY_FORM
