#pragma once
/// Triangles cut along the texel lines: the pieces over which everything is integrated.
///
/// A piece is the part of one triangle in one cell, convex, with at most seven vertices. Whether an
/// edge crosses a line, and in which order along it, is decided exactly (integers of texel_point.h
/// and their quotients), so a vertex or an edge that lies on a line is an ordinary case, neighbours
/// agree, and the areas of a triangle's pieces add up to its own. Coordinates of crossings are
/// rounded once.

#include <array>

#include "mq/atlas/texel_point.h"

namespace mq {

struct Piece {
  static constexpr int max_vertices = 8;
  static constexpr signed char grid_line = -1;

  struct Vertex {
    double x, y;         ///< in the cell: [0, 1], y downward
    signed char corner;  ///< the triangle's corner that it is, or -1
    signed char side;  ///< what the side to the next vertex lies on: edge 0 to 2 (edge k runs from
                       ///< corner k to the next), or `grid_line`
  };

  int row = 0, column = 0;  ///< of the cell, before any wrapping
  int count = 0;
  std::array<Vertex, max_vertices> vertices;

  /// The area in texels²; positive whatever the orientation.
  double area() const;
};

/// Rows of cells that a triangle has area in: first and one past the last.
std::array<int, 2> rows_of(const std::array<TexelPoint, 3>& corners);

/// Visits what a triangle covers of one row of cells, from left to right: `cut(piece)` for cells
/// covered in part, `whole(row, first_column, last_column)` for runs of cells covered altogether.
/// The triangle must have area.
template <class Cut, class Whole>
void clip_row(const std::array<TexelPoint, 3>& corners, int row, const Cut& cut,
              const Whole& whole);

/// Pieces smaller than this, in texels², are left out: nothing of them survives rounding.
inline constexpr double smallest_piece = 1e-22;

/// The whole cell as a piece.
Piece whole_cell(int row, int column);

namespace detail {

/// The part of a triangle in one row of cells: x = column + fraction, y in the row.
struct RowPiece {
  struct Vertex {
    int column;
    double x, y;
    signed char corner, side;
  };
  int count = 0;
  std::array<Vertex, Piece::max_vertices> vertices;
  void add(const Vertex& v) { vertices[count++] = v; }
};

RowPiece clip_to_row(const std::array<TexelPoint, 3>& corners, int row);

/// Moves the part left of the line x = `column` + 1 out of `rest`.
Piece split_column(const std::array<TexelPoint, 3>& corners, int row, int column, RowPiece& rest);

/// One past the last column that can be covered altogether, where `rest` starts with a whole side
/// on the line x = `column`; that side is moved there. Returns `column` where there is no such
/// column.
int skip_whole(int column, RowPiece& rest);

std::array<int, 2> columns_of(const RowPiece& piece);
bool is_whole(const Piece& piece);

}  // namespace detail

template <class Cut, class Whole>
void clip_row(const std::array<TexelPoint, 3>& corners, int row, const Cut& cut,
              const Whole& whole) {
  detail::RowPiece rest = detail::clip_to_row(corners, row);
  const auto [first, end] = detail::columns_of(rest);
  for (int column = first; column < end; ++column) {
    const Piece piece = detail::split_column(corners, row, column, rest);
    if (!detail::is_whole(piece)) {
      if (piece.count >= 3) cut(piece);
      continue;
    }
    const int next = detail::skip_whole(column + 1, rest);
    whole(row, column, next - 1);
    column = next - 1;
  }
}

}  // namespace mq
