#pragma once
/// Charts as sets of cells, and the cells that are taken at a time.

#include <array>
#include <cstdint>
#include <vector>

#include "mq/unwrap/detail/pack.h"
#include "mq/unwrap/touched_cells.h"

namespace mq {

/// A chart as the cells it touches, and these widened by the gutter, both in the frame whose cell
/// (0, 0) is the lowest of the wide one. Rows go upward.
struct PackShape {
  int width = 0, height = 0;  ///< of the wide one
  std::vector<CellRun> touched, wide;
  std::size_t longest = 0;           ///< which of the wide runs is
  Vector2 middle = Vector2::Zero();  ///< centre of mass of the touched cells
  double angle = 0;
  Vector2 origin = Vector2::Zero();  ///< the point of the turned, scaled chart at cell (0, 0)
};

/// The shape of a chart turned by `angle`, scaled (cells per unit) and made wider by `pad` cells
/// all around, any number. Cells that are touched in rounding only are touched.
PackShape make_shape(const PackChart& chart, double angle, double scale, double pad, int gutter);

/// The angle at which the chart's box is smallest, lying.
double smallest_box_angle(const PackChart& chart);

/// A texture's cells over time: per frame which are taken.
class PackVolume {
 public:
  /// Frames are 0 to `frames` − 1.
  PackVolume(int width, int height, int frames);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Takes the cells, moved by (x, y) and cut off at the border, in the frames [first, last].
  void take(const std::vector<CellRun>& cells, int x, int y, int first, int last);

  /// Makes `find` look at what is taken in any of the frames; in the rows [from, to) only, where
  /// these are given: it must not be asked for others then.
  void look(int first, int last);
  void look(int first, int last, int from, int to);

  /// The least column from `x` on at which all wide cells of a shape, moved by it and by row y, are
  /// free and inside; −1: none.
  int find(const PackShape& shape, int x, int y) const;

 private:
  using Word = std::uint64_t;
  Word* row(std::vector<Word>& board, int y) { return board.data() + std::size_t(y) * words_; }
  void count_runs(int y);

  int width_, height_, frames_, words_;
  std::vector<std::vector<Word>> covers_;  // per node of the tree, taken in all its frames
  std::vector<std::vector<Word>> anys_;    // per node, taken in any of its frames
  std::vector<Word> view_;                 // what `find` looks at
  std::vector<std::int16_t> ahead_;        // from a cell on: free cells, or minus the taken ones
  std::vector<int> longest_;               // per row, of free cells
};

}  // namespace mq
