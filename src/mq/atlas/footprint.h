#pragma once
/// The texels that a triangle reads: the corners of the cells it has area in.

#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"

namespace mq {

/// Texels of one row, before any wrapping.
struct TexelSpan {
  int row = 0;
  int first = 0, end = 0;  ///< columns; one past the last
};

/// The footprints of all triangles that have a chart. Linear in the rows that they cross; exact, as
/// `clip_row` is, so a triangle that ends on a texel line does not read what lies beyond it.
class Footprints {
 public:
  explicit Footprints(const Atlas& atlas, const Progress& progress = {});

  /// Row by row; some may be empty.
  std::span<const TexelSpan> of(int triangle) const {
    return {spans_.data() + offsets_[triangle], offsets_[triangle + 1] - offsets_[triangle]};
  }

 private:
  std::vector<std::size_t> offsets_;  // per triangle
  std::vector<TexelSpan> spans_;
};

}  // namespace mq
