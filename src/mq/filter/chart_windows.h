#pragma once
/// Charts cut into small windows of texels, around each of which the surface goes on: what a filter of patches works on.

#include <span>
#include <vector>

#include "mq/atlas/texel_grid.h"
#include "mq/fem/texel_space.h"
#include "mq/trace/atlas_walk.h"

namespace mq {

/// The unknowns of one chart in one square of `ChartWindows::side` × `side` texels, and around them what a border
/// reaches: texels of the same chart, and beyond it those of others that one meets by walking on over its seams.
struct ChartWindow {
  int width = 0, height = 0;           ///< of all, the border included
  std::vector<int> unknowns;           ///< row by row; −1 where the surface has ended
  std::vector<char> own;               ///< 1: one of the square's; 2: another of the same chart; 0: from beyond
  int column = 0, row = 0;             ///< of the left top one in the texture, may lie outside it
};

class ChartWindows {
 public:
  static constexpr int side = 32;

  /// Whether windows look beyond seams.
  enum class Beyond { seams, nothing };

  /// All three must outlive the object. Costs 4 bytes a texel of the textures and 12 an unknown, and twice the former
  /// for a moment.
  ChartWindows(const Surface& surface, const Atlas& atlas, const TexelSpace& space);

  int count() const { return int(first_.size()) - 1; }

  /// The texels of window number k with a border of `border` texels. Texels beyond a seam are the nearest to where one
  /// gets from the nearest texel of the chart: whole values, so that noise stays what it is.
  ChartWindow window(int k, int border, Beyond beyond = Beyond::seams) const;

 private:
  bool is_of(int chart, int texture, int column, int row, int& unknown) const;
  void look_beyond(ChartWindow& window) const;
  int across_seams(int seed, const Vector2& way) const;
  AtlasPlace place_of(int unknown) const;

  const Surface& surface_;
  const Atlas& atlas_;
  const Texels& texels_;
  TexelGrid grid_;
  AtlasWalk walk_;
  std::vector<int> unknown_;    ///< per texel of all textures, −1: none
  std::vector<int> chart_;      ///< per unknown
  std::vector<int> triangle_;   ///< per unknown the one of its chart that covers its centre, or −1
  std::vector<int> order_;      ///< unknowns, window by window
  std::vector<int> first_;      ///< of each window in `order_`, and one more
};

}  // namespace mq
