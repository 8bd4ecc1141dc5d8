#pragma once
/// The seam-continuous basis as it was published, to compare `TexelSpace` with.

#include <array>
#include <map>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/space.h"

namespace mq {

struct ChartOutline;

/// Functions of texels that are continuous over seams, by quadratic elements (thesis 5.5; [prada2018gradient]). Cells of
/// the texel lattice are cut to the charts, crossings of seams are carried to the other side, and each piece is
/// triangulated such that circles around triangles are empty as far as its sides allow. A node is a vertex or the middle of
/// an edge, Q_n its quadratic Lagrange element, ñ all nodes that are one point of the surface, B_t the bilinear function of a
/// texel, each in its own chart:
///
///     φ_t = Σ_ñ (1/|ñ| Σ_{n ∈ ñ} B_t(n)) Σ_{n ∈ ñ} Q_n .
///
/// A node at distance d from a seam costs 1/d of energy for each unit by which values on the seam differ from the bilinear
/// ones, without bound as d goes to 0: what `Seams::blend` is for.
///
/// For textures that do not repeat. Throws `Unsupported` where a cell's part of a chart has a hole or touches itself in a
/// point.
class QuadraticSeamBasis {
 public:
  enum class Values {
    mean,  ///< 1/|ñ|: functions add up to 1
    sum    ///< 1 in its place (the thesis' φ̄): they agree with B_t where that is not 0, and do not
  };

  QuadraticSeamBasis(const Surface& surface, const Atlas& atlas, Values values = Values::mean);

  int size() const { return int(texels_.size()); }

  /// Texture, column and row of each.
  const std::vector<std::array<int, 3>>& texels() const { return texels_; }

  /// a·M + b·S, integrated exactly on the common refinement with the triangles of the surface.
  SparseMatrix system(double a, double b) const;

  /// Functions that are not 0 at a point of a triangle of a chart.
  std::vector<BasisWeight> basis_at(int triangle, const Vector3& barycentric) const;

  /// How far the corner of an element that is not on a seam is from the seam that it has a side on, at least; texels.
  double nearest_node() const { return nearest_node_; }

 private:
  using Point = std::array<double, 2>;
  /// Coefficients of functions at a node.
  using Node = std::vector<BasisWeight>;
  struct Element {
    std::array<Point, 3> corners;  ///< in the cell
    std::array<Node, 6> nodes;     ///< corners, then the middles of the sides that begin at them
  };
  struct Cell {
    std::vector<std::pair<int, std::vector<Point>>> pieces;  ///< triangles of the surface, and what of the cell they are
    std::vector<Element> elements;
  };

  int number(int texture, int column, int row);
  Node bilinear_at(int texture, double column, double row);
  Node node_at(const ChartOutline& outline, std::size_t point, std::size_t next);
  void add_elements(const ChartOutline& outline, Cell& cell);

  const Surface& surface_;
  const Atlas& atlas_;
  const Values values_;
  std::vector<std::array<int, 3>> texels_;
  std::map<std::array<int, 3>, int> numbers_;
  std::map<std::array<int, 3>, Cell> cells_;  ///< by chart, row, column
  double nearest_node_;
};

}  // namespace mq
