#pragma once
/// Integral curves on an image, by the same automaton as on a mesh.

#include <array>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/trace/surface_flow.h"

namespace mq {

/// The domain is the rectangle between the centres of the outermost pixels, pixel (i, j) at (i, j).
/// Each cell between four pixels is cut into two triangles along a diagonal whose direction
/// alternates like a chess board: neighbouring triangles are mirror images, and no direction is
/// preferred. Nothing of this is stored; a flow holds the potential or the field and no more.
///
/// Triangle 2·(j·w + i) + s of cell (i, j), w the next power of two from the width, has its right
/// angle in the cell's upper (s = 0) or lower (s = 1) row; that is its corner 0. What happens at
/// edges, vertices and the border is said at `SurfaceFlow`.
class GridFlow {
 public:
  /// X = −∇P, P linear on triangles: width · height values, row by row. Throws `InvalidInput` when
  /// the image has fewer than 2 pixels a side or more than 2²⁷ in all, or P has the wrong size or
  /// is not finite.
  static GridFlow downhill(int width, int height, std::vector<double> potential);

  /// X constant on each cell, (width − 1) · (height − 1) vectors, to the right and down, in pixels
  /// per unit of time: as the thesis has it for images.
  static GridFlow along(int width, int height, std::vector<std::array<double, 2>> field);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Follows each start (triangles of the grid) for `time`, and from every pixel, row by row.
  Traced trace(std::span<const SurfacePoint> starts, double time,
               const Progress& progress = {}) const;
  Traced trace_pixels(double time, const Progress& progress = {}) const;

  /// Column and row of a point.
  std::array<double, 2> place(const SurfacePoint& point) const;

  /// The point at a column and row, the nearest one where that is outside the domain.
  SurfacePoint point(double column, double row) const;

  // What `walk::follow` asks for.
  std::array<double, 3> rates(int t) const;
  int across(int t, int k) const;
  int leave(int t, int k) const;
  double slide_rate(int t, int k) const;
  std::int64_t exit(int t, int k) const;
  double speed(int t) const;
  void prefetch(int t) const;

 private:
  /// A triangle's right angle, and which way its two short sides run: to corner 1, then to
  /// corner 2.
  struct Shape {
    int column, row;    ///< of corner 0
    int column1, row1;  ///< of corner 1 less corner 0: one is 0, the other ±1
    int column2, row2;  ///< of corner 2 less corner 0
  };

  GridFlow(int width, int height);
  Shape shape(int t) const;
  int triangle(int column, int row, int s) const {
    return (row << (row_shift_ + 1)) + 2 * column + s;
  }
  int column_of(int t) const { return (t >> 1) & ((1 << row_shift_) - 1); }
  int row_of(int t) const { return t >> (row_shift_ + 1); }
  std::size_t cell(int t) const { return std::size_t(row_of(t)) * (width_ - 1) + column_of(t); }
  int pixel(int column, int row) const { return row * width_ + column; }
  double slide_rate_from(int t, int k) const;
  template <class Start, class Finish>
  PathCounts run(std::int64_t count, double time, const Start& start, const Finish& finish,
                 const Progress& progress) const;

  int width_, height_;
  int row_shift_ = 1;              ///< triangles of a row are numbered from 2·row·2^row_shift on
  std::vector<double> potential_;  ///< per pixel; empty where a field is given
  std::vector<std::array<double, 2>> field_;  ///< per cell
};

}  // namespace mq
