// Sutherland and Hodgman's clipping, first to the two lines of a row, then line by line to columns.
// A crossing of the edge a → b with the line x = X has
//
//     y = a.y + (X − a.x) (b.y − a.y) / (b.x − a.x),
//
// computed as a 128-bit quotient and remainder: the integer part, and with it every comparison with
// a texel line, is exact. The edge is taken in the order of its end points' coordinates, so both
// triangles at it find the same bits.

#include "mq/atlas/clip.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace detail {
namespace {

constexpr std::int64_t one = TexelPoint::one;

struct Quotient {
  std::int64_t whole;  ///< rounded down
  double rest;         ///< in [0, 1)
};

Quotient divide(Int128 numerator, std::int64_t denominator) {
  if (denominator < 0) numerator = -numerator, denominator = -denominator;
  Int128 quotient = numerator / denominator;
  Int128 remainder = numerator - quotient * denominator;
  if (remainder < 0) remainder += denominator, --quotient;
  return {std::int64_t(quotient), double(std::int64_t(remainder)) / double(denominator)};
}

constexpr double below_one = 1 - 0x1p-53;

/// The crossing with the line y = row.
RowPiece::Vertex cross_row(TexelPoint a, TexelPoint b, int row, double y, signed char side) {
  if (b < a) std::swap(a, b);
  const Quotient q = divide(Int128(std::int64_t(row) * one - a.y) * (b.x - a.x), b.y - a.y);
  const std::int64_t x = a.x + q.whole;
  const double fraction = (double(x & (one - 1)) + q.rest) / double(one);
  return {floor_texel(x), std::min(fraction, below_one), y, -1, side};
}

/// Height in the row of the crossing with the line x = column.
double cross_column(TexelPoint a, TexelPoint b, int row, int column) {
  if (b < a) std::swap(a, b);
  const Quotient q = divide(Int128(std::int64_t(column) * one - a.x) * (b.y - a.y), b.x - a.x);
  const std::int64_t y = a.y + q.whole - std::int64_t(row) * one;
  return std::clamp((double(y) + q.rest) / double(one), 0.0, 1.0);
}

/// −1 left of, 0 on, 1 right of the line x = column.
int side_of(const RowPiece::Vertex& v, int column) {
  if (v.column != column) return v.column < column ? -1 : 1;
  return v.x > 0 ? 1 : 0;
}

}  // namespace

RowPiece clip_to_row(const std::array<TexelPoint, 3>& corners, int row) {
  const std::int64_t low = std::int64_t(row) * one, high = low + one;
  RowPiece piece;
  for (signed char k = 0; k < 3; ++k) {
    const TexelPoint &a = corners[k], &b = corners[k == 2 ? 0 : k + 1];
    if (a.y >= low && a.y <= high) {
      const bool leaves = (a.y == high && b.y > high) || (a.y == low && b.y < low);
      piece.add({floor_texel(a.x), double(a.x & (one - 1)) / double(one),
                 double(a.y - low) / double(one), k, leaves ? Piece::grid_line : k});
    }
    const bool crosses_low = std::min(a.y, b.y) < low && low < std::max(a.y, b.y);
    const bool crosses_high = std::min(a.y, b.y) < high && high < std::max(a.y, b.y);
    if (a.y < b.y) {
      if (crosses_low) piece.add(cross_row(a, b, row, 0, k));
      if (crosses_high) piece.add(cross_row(a, b, row + 1, 1, Piece::grid_line));
    } else {
      if (crosses_high) piece.add(cross_row(a, b, row + 1, 1, k));
      if (crosses_low) piece.add(cross_row(a, b, row, 0, Piece::grid_line));
    }
  }
  return piece;
}

Piece split_column(const std::array<TexelPoint, 3>& corners, int row, int column, RowPiece& rest) {
  const int line = column + 1;
  Piece left;
  left.row = row;
  left.column = column;
  RowPiece right;
  const auto add_left = [&](const RowPiece::Vertex& v, signed char side) {
    left.vertices[left.count++] = {v.x + (v.column - column), v.y, v.corner, side};
  };
  const auto add_right = [&](RowPiece::Vertex v, signed char side) {
    v.side = side;
    right.add(v);
  };
  for (int k = 0; k < rest.count; ++k) {
    const RowPiece::Vertex &v = rest.vertices[k],
                           &w = rest.vertices[k + 1 == rest.count ? 0 : k + 1];
    const int sv = side_of(v, line), sw = side_of(w, line);
    if (sv <= 0) add_left(v, sv == 0 && sw > 0 ? Piece::grid_line : v.side);
    if (sv >= 0) add_right(v, sv == 0 && sw < 0 ? Piece::grid_line : v.side);
    if (sv * sw >= 0) continue;
    const double y = v.side < 0 ? v.y
                                : cross_column(corners[v.side],
                                               corners[v.side == 2 ? 0 : v.side + 1], row, line);
    const RowPiece::Vertex crossing{line, 0.0, y, -1, v.side};
    add_left(crossing, sv < 0 ? Piece::grid_line : v.side);
    add_right(crossing, sv < 0 ? v.side : Piece::grid_line);
  }
  rest = right;
  return left;
}

bool is_whole(const Piece& piece) {
  if (piece.count != 4) return false;
  for (int k = 0; k < 4; ++k) {
    const Piece::Vertex& v = piece.vertices[k];
    const bool at_corner = (v.x == 0 || v.x == 1) && (v.y == 0 || v.y == 1);
    if (!at_corner || v.corner >= 0 || v.side >= 0) return false;
  }
  return true;
}

int skip_whole(int column, RowPiece& rest) {
  const auto on_line = [&](int k) {
    const RowPiece::Vertex& v = rest.vertices[k];
    return v.column == column && v.x == 0;
  };
  int end = column;
  bool first = true;
  for (int k = 0; k < rest.count; ++k) {
    const int next = k + 1 == rest.count ? 0 : k + 1;
    // From the full side on the line the outline must run along the texel lines, not inward.
    if (on_line(k) != on_line(next) && rest.vertices[k].side >= 0) return column;
    if (on_line(k)) continue;
    end = first ? rest.vertices[k].column : std::min(end, rest.vertices[k].column);
    first = false;
  }
  if (end <= column) return column;
  for (int k = 0; k < rest.count; ++k)
    if (on_line(k)) rest.vertices[k].column = end;
  return end;
}

std::array<int, 2> columns_of(const RowPiece& piece) {
  if (piece.count == 0) return {0, 0};
  int first = piece.vertices[0].column, end = first;
  for (int k = 0; k < piece.count; ++k) {
    const RowPiece::Vertex& v = piece.vertices[k];
    first = std::min(first, v.column);
    end = std::max(end, v.x > 0 ? v.column + 1 : v.column);
  }
  return {first, end};
}

}  // namespace detail

double Piece::area() const {
  double twice = 0;
  for (int k = 2; k < count; ++k)
    twice += (vertices[k - 1].x - vertices[0].x) * (vertices[k].y - vertices[0].y) -
             (vertices[k - 1].y - vertices[0].y) * (vertices[k].x - vertices[0].x);
  return std::abs(twice) / 2;
}

std::array<int, 2> rows_of(const std::array<TexelPoint, 3>& corners) {
  const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  return {floor_texel(low), floor_texel(high - 1) + 1};
}

Piece whole_cell(int row, int column) {
  Piece piece;
  piece.row = row;
  piece.column = column;
  piece.count = 4;
  piece.vertices[0] = {0, 0, -1, Piece::grid_line};
  piece.vertices[1] = {1, 0, -1, Piece::grid_line};
  piece.vertices[2] = {1, 1, -1, Piece::grid_line};
  piece.vertices[3] = {0, 1, -1, Piece::grid_line};
  return piece;
}

}  // namespace mq
