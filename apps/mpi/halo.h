#pragma once
/// Rows that a process needs and others own.

#include <cstdint>
#include <vector>

#include "numbering.h"

namespace mq::shared {

class Halo {
 public:
  /// `wanted` are numbers of other processes' rows, ascending. Every process must call it, and all that it has.
  Halo(const Processes& processes, const Numbering& numbering, const std::vector<std::int64_t>& wanted);

  /// Own rows that other processes want, per process.
  const std::vector<std::vector<int>>& given() const { return given_; }

  /// The wanted rows, in their order, of a signal of which every process has its own.
  Signal fetched(const Signal& own) const;

  /// Adds what this process has for the wanted rows to those that own them.
  void add_to_owners(const Signal& wanted, Signal& own) const;

 private:
  const Processes& processes_;
  std::vector<std::vector<int>> given_;
  std::vector<std::size_t> counts_;  ///< wanted of each process, whose rows follow one another
};

}  // namespace mq::shared
