#pragma once
/// The connected components of a system whose rows are parted among processes.

#include <optional>
#include <vector>

#include "halo.h"
#include "mq/linear/matrix.h"

namespace mq::shared {

class SharedComponents {
 public:
  /// Of the matrix of a part's space; empty where the part is. Every process must call it, and `sums`.
  SharedComponents(const Processes& processes, const TexelPart& part, const Numbering& numbering,
                   const SparseMatrix& A);

  /// Components that this process has to do with, and per unknown of the part's space which one it is in.
  int count() const { return int(ids_.size()); }
  const std::vector<int>& component() const { return component_; }

  /// What all processes have for each of these together, of what this one has: a row each.
  Signal sums(const Signal& here) const;

 private:
  const Numbering& numbering_;
  std::vector<std::int64_t> ids_;  ///< the least number of a texel of each, ascending
  std::vector<int> component_;
  std::optional<Halo> others_;     ///< the rows of those that others own
};

}  // namespace mq::shared
