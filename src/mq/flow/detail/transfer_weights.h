#pragma once
/// Transfers of fields between levels, used for signals: their weights without the turns.

#include <cmath>

#include "mq/base/parallel.h"
#include "mq/linear/block_multigrid.h"
#include "mq/linear/matrix.h"

namespace mq {

inline double weight_of(const BlockTransfer::Entry& entry) {
  return std::hypot(double(entry.cosine), double(entry.sine));
}

/// A signal on the coarse level on the fine one.
inline Signal prolongated_by_weights(const BlockTransfer& P, const Signal& signal) {
  Signal fine = Signal::Zero(P.rows(), signal.cols());
  parallel_for(P.rows(), [&](std::int64_t i) {
    for (int e = P.starts[std::size_t(i)]; e < P.starts[std::size_t(i) + 1]; ++e)
      fine.row(i) += weight_of(P.entries[std::size_t(e)]) * signal.row(P.entries[std::size_t(e)].column);
  });
  return fine;
}

}  // namespace mq
