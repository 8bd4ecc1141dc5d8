#pragma once
/// Which texels of the pictures the texels of a part are, where charts that share texels are laid apart.

#include <optional>
#include <vector>

#include "mq/atlas/separate_overlaps.h"
#include "mq/fem/copy_rank.h"
#include "mq/fem/texel_part.h"
#include "processes.h"

namespace mq::shared {

/// As `TexelCopies` on one machine, of the own texels of a part, row by row. Where nothing is laid apart a texel is its
/// own and only copy.
class SharedCopies {
 public:
  /// As long as the part has a space. Every process must call it.
  SharedCopies(const Processes& processes, const Surface& surface, const std::optional<SeparatedAtlas>& apart,
               const TexelPart& part);

  /// The texel of the pictures.
  Texels::Place home(int row) const;
  /// Whether the picture shows this copy, and whether a place given by texel means it.
  bool is_shown(int row) const { return shown_.empty() || shown_[std::size_t(row)] != 0; }
  bool is_meant(int row) const { return meant_.empty() || meant_[std::size_t(row)] != 0; }

  /// How many texels of the pictures have several copies, of all processes.
  std::int64_t shared_texels() const { return shared_texels_; }

 private:
  void compare(const Processes& processes, const std::vector<CopyRank>& ranks);

  const std::optional<SeparatedAtlas>& apart_;
  const TexelPart& part_;
  std::vector<char> shown_, meant_;
  std::int64_t shared_texels_ = 0;
};

}  // namespace mq::shared
