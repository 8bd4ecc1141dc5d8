#pragma once
/// What is done to all values of a signal, by all threads.

#include <cmath>

#include "mq/base/parallel_values.h"
#include "mq/linear/matrix.h"

namespace mq {

inline Signal zero_signal(Eigen::Index rows, Eigen::Index columns) {
  Signal signal(rows, columns);
  parallel_fill(signal.data(), signal.size(), 0.0);
  return signal;
}

inline bool is_zero(const Signal& signal) {
  const double* const values = signal.data();
  return parallel_all(signal.size(), [&](std::int64_t begin, std::int64_t end) {
    return std::all_of(values + begin, values + end, [](double value) { return value == 0; });
  });
}

inline bool is_finite(const Signal& signal) {
  const double* const values = signal.data();
  return parallel_all(signal.size(), [&](std::int64_t begin, std::int64_t end) {
    return std::all_of(values + begin, values + end, [](double value) { return std::isfinite(value); });
  });
}

/// signal += other, of the same size.
inline void add(const Signal& other, Signal& signal) {
  parallel_blocks(signal.size(), values_at_once, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) signal.data()[i] += other.data()[i];
  });
}

/// signal *= factor.
inline void scale(double factor, Signal& signal) {
  parallel_blocks(signal.size(), values_at_once, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) signal.data()[i] *= factor;
  });
}

}  // namespace mq
