#pragma once
/// Whether an unknown has the same values in two signals, in every channel and to the last bit.

#include "mq/linear/matrix.h"

namespace mq {

inline bool same_row(const Signal& a, const Signal& b, Eigen::Index row) {
  return (a.row(row).array() == b.row(row).array()).all();
}

}  // namespace mq
