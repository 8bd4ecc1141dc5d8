#pragma once
/// A symmetric scaling that keeps single precision away from its ends.

#include <cstdint>
#include <vector>

#include "mq/linear/transfer.h"

namespace mq {

/// Â = common · D·A·D with D diagonal and, but for a few rows, 1: x = D·x̂, b̂ = common · D·b.
/// All factors in D are powers of two, so that scaling rounds nothing.
struct Scaling {
  double common = 1;
  std::vector<float> rows;             ///< D; empty: the identity
  std::vector<WeightedIndex> special;  ///< the rows where D is not 1, and 1/D there

  double row(std::int64_t i) const { return rows.empty() ? 1.0 : double(rows[i]); }
  double operator()(std::int64_t i, std::int64_t j) const { return common * row(i) * row(j); }
};

}  // namespace mq
