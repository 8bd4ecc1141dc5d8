#pragma once
/// What conjugate gradients in single precision do to the vectors of a scaled system, four channels
/// together. The four lanes of a single channel are partial sums of that channel.

#include "mq/linear/detail/scaling.h"
#include "mq/linear/lanes.h"
#include "mq/linear/matrix.h"

namespace mq {

/// A value per channel.
typedef double Double4 __attribute__((vector_size(32)));

Double4 dot(const LaneVector& a, const LaneVector& b);

/// ‖D⁻¹·r‖² per channel: the residual of the system as it was given.
Double4 squared_norm(const Scaling& scaling, LaneVector& r);

/// p = z + β·p
void next_direction(const LaneVector& z, Double4 beta, LaneVector& p);

/// r −= α·q; returns ‖D⁻¹·r‖² per channel.
Double4 reduce_residual(const Scaling& scaling, LaneVector& q, Double4 alpha, LaneVector& r);

/// The largest values by size, per channel.
struct LargestValues {
  Double4 change{}, value{};

  friend LargestValues operator+(const LargestValues& a, const LargestValues& b) {
    return {a.change > b.change ? a.change : b.change, a.value > b.value ? a.value : b.value};
  }
};

/// Columns first … first + channels − 1 of X += α·p. Returns the largest of α·p and of those columns,
/// which special rows of the scaling (units of their own) have no part in.
LargestValues add_to_solution(const Scaling& scaling, const LaneVector& p, Double4 alpha, int first,
                        int channels, Signal& X);

}  // namespace mq
