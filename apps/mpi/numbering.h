#pragma once
/// One numbering for the texels of all processes, and their values beyond a process's own.

#include <span>
#include <vector>

#include "mq/fem/texel_part.h"
#include "mq/filter/shared_unknowns.h"
#include "processes.h"

namespace mq::shared {

/// Texels are numbered process by process, in the order of each part. A process knows the numbers of the texels of
/// its halo too.
class Numbering {
 public:
  /// Asks the owners of the halo. Every process must call it.
  Numbering(const Processes& processes, const TexelPart& part);

  int own_count() const { return own_count_; }
  std::int64_t first() const { return first_; }
  std::int64_t total() const { return total_; }

  /// Per unknown of the part's space its number; −1 for a texel that its owner does not have, which only
  /// incomplete rows of the halo reach.
  const std::vector<std::int64_t>& numbers() const { return numbers_; }

  /// The process that owns a number.
  int owner(std::int64_t number) const;

  /// Fills in the rows of the halo, per unknown of the part's space, from those that own them. Every process must
  /// call it.
  void fill_halo(Signal& values) const;
  void fill_halo(std::span<double> values, int channels) const;

 private:
  const Processes& processes_;
  const TexelPart& part_;
  int own_count_ = 0;
  std::int64_t first_ = 0, total_ = 0;
  std::vector<std::int64_t> starts_;               ///< per process, and the end
  std::vector<std::int64_t> numbers_;
  std::vector<std::vector<int>> asked_, answered_;  ///< per process unknowns of ours: of the halo, and own ones
};

/// The unknowns of a part for algorithms of the library. All must outlive it.
SharedUnknowns shared_unknowns(const Processes& processes, const TexelPart& part, const Numbering& numbering);

}  // namespace mq::shared
