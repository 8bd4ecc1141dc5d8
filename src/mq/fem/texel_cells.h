#pragma once
/// The integrals of a texel space, cell by cell: what M and S, and S with a modulation, are rebuilt
/// from without cutting a triangle again.
///
/// With x_0 = 1 − x, x_1 = x and the same for y, the bilinear function of corner (p, q) of a cell
/// is x_p y_q. Over a piece Q of a triangle with density √|g| and √|g| g⁻¹ = [[a, b], [b, c]]
/// everything follows from nine moments
///
///     m_pq = ∫_Q β_p(x) β_q(y) dx dy,   β_0 = x_0²,  β_1 = x_0 x_1,  β_2 = x_1²,
///
/// which are positive, so that cells of which a chart covers very little keep their relative
/// accuracy: mass √|g| m_{p+r, q+s}, and stiffness sums of moments (thesis 5.7, by a rule
/// that is exact for them).

#include <array>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/atlas/clip.h"
#include "mq/atlas/texel_grid.h"
#include "mq/base/overwritten.h"
#include "mq/base/progress.h"
#include "mq/fem/detail/seam_basis.h"

namespace mq {

/// Corner order of a cell: left top, right top, left bottom, right bottom.
struct CellIntegrals {
  std::array<double, 9> mass{};       ///< Σ √|g| m_pq at index p + 3 q
  std::array<double, 6> stiffness{};  ///< S_01, S_02, S_03, S_12, S_13, S_23; rows sum to 0
};

/// ∫ β_p β_q over a convex polygon in a cell, at index p + 3 q, in texels².
std::array<double, 9> bernstein_moments(std::span<const std::array<double, 2>> polygon);
std::array<double, 9> bernstein_moments(const Piece& piece);
/// The same of a whole cell.
std::array<double, 9> whole_moments();

/// integrals += those of a piece with these moments and this metric.
void add_integrals(const std::array<double, 9>& moments, const TexelMetric& metric,
                   CellIntegrals& integrals);

/// The symmetric matrices of a few texels coupled by the pieces of one chart in one cell near a
/// seam, or by some of their points where these have very many texels (or, for soft continuity, by
/// one stretch of a seam).
struct SeamBlocks {
  struct Block {
    int cell;                  ///< of TexelGrid, or -1
    int first, count;          ///< its texels: texels[first ... first + count)
    std::int64_t first_value;  ///< its upper triangles by rows: mass and stiffness from here
  };
  std::vector<Block> blocks;
  OverwrittenVector<int> texels;  ///< numbers of TexelGrid
  OverwrittenVector<double> mass, stiffness;

  /// Of a cell near seams, whose matrices are not those of bilinear functions: what the pieces of a chart
  /// there have together.
  struct CellMean {
    int cell;
    double surface = 0;              ///< area on the surface
    std::array<double, 3> metric{};  ///< Σ area in texels² · (a, b, c) of `TexelMetric`
  };
  std::vector<CellMean> means;

  static int index(int i, int j, int count) {  ///< of entry (i, j), i <= j, of an upper triangle
    return i * count - i * (i - 1) / 2 + (j - i);
  }
};

/// All integrals of an atlas.
struct TexelCells {
  /// Per cell of the grid: -1 nothing, a triangle that alone covers it altogether, or
  /// triangle_count + index into `cut`.
  std::vector<int> kind;
  std::vector<CellIntegrals> cut;
  struct CutInfo {
    double coverage = 0;   ///< area of all pieces in the cell, texels²; above 1: charts overlap
    double surface = 0;    ///< ... and on the surface
    float largest = 0;     ///< area of the largest piece ...
    int triangle = -1;     ///< ... and its triangle, of the chart of earliest turn where several are as large
    bool several = false;  ///< pieces of several charts
  };
  std::vector<CutInfo> info;         ///< per entry of `cut`
  std::vector<CellIntegrals> whole;  ///< per triangle, the integrals of a cell inside it
  SeamBlocks seams;
};

/// Cuts every triangle and integrates. `seams` and `near` null: bilinear everywhere, discontinuous
/// at seams. `wanted`: per cell of the grid 1, or 0 where nothing is to be integrated; empty: all are. Parallel over bands of rows, the same bits for any number of threads.
TexelCells integrate_cells(const Surface& surface, const Atlas& atlas,
                           const std::vector<TexelMetric>& metrics, const TexelGrid& grid,
                           const Seams* seams, const NearSeams* near, std::span<const char> wanted,
                           const Progress& progress);

/// Whether a piece of a triangle says better where a texel lies than one of another (−1: of none): the
/// larger, and where copies of a part share the texture, the one whose chart's turn is earlier.
bool tells_more(const Atlas& atlas, float area, int triangle, float other_area, int other_triangle);

}  // namespace mq
