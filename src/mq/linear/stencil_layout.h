#pragma once
/// Which rows of a matrix are 3 × 3 stencils.

#include <array>
#include <vector>

#include "mq/linear/kernels/stencil_kernels.h"

namespace mq {

/// Runs in the order in which they are relaxed.
struct StencilTiles {
  std::vector<StencilRun> runs;  ///< tile by tile, each tile's from top to bottom
  std::vector<int> tiles;        ///< tile t has runs tiles[t] … tiles[t + 1] − 1
  std::vector<int> colours;      ///< colour c has tiles colours[c] … colours[c + 1] − 1;
                                 ///< no two of them couple
};

/// Which rows are stencils, and the order in which they are relaxed.
struct StencilLayout : StencilTiles {
  static constexpr int max_run = 128;

  int rows = 0;
  std::vector<int> irregular;        ///< the rows in no run, ascending
  std::vector<int> clustered;        ///< rows of runs, ascending, that depend so strongly on few
                                     ///< others that they are relaxed together with those as well

  /// The rows that patches are made of: the irregular and then the clustered ones.
  int listed_count() const { return int(irregular.size() + clustered.size()); }
  int listed(int position) const {
    const int count = int(irregular.size());
    return position < count ? irregular[position] : clustered[position - count];
  }
};

/// Per row the number of the run it is in, −1: none.
std::vector<int> runs_of_rows(const StencilLayout& layout);

/// The columns of row first + i of a run, row by row of the picture.
inline std::array<int, 9> stencil_columns(const StencilRun& run, int i) {
  const int up = run.up + i, k = run.first + i, down = run.down + i;
  return {up - 1, up, up + 1, k - 1, k, k + 1, down - 1, down, down + 1};
}

}  // namespace mq
