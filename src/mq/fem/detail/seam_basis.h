#pragma once
/// The seam-continuous basis next to seams (thesis 5.5), in a form whose matrices stay well
/// conditioned however near texel centres and texel lines come to a seam.
///
/// In the cells of a chart that come within η = `Seams::blend` texels of one of its seams,
///
///     φ(x) = B(x) + Σ_e λ_e(x) (σ_e(s_e) − B(p_e)):
///
/// B the chart's bilinear function; e the seams of the chart within η of x; p_e the point of e
/// nearest to x, at distance d_e and parameter s_e; σ_e the mean over the copies of p_e
/// (`Seams::add_value`); λ_e weights that continuously go from 1 on the seam to 0 at distance η,
///
///     λ_e = (1 − d/η) r_e / Σ r,   r_e = max(0, g_e / max g − ½)²,   g_e = 1/d_e − 1/η,   d = min
///     d_e.
///
/// On a seam φ = σ, the same from both sides; where d ≥ η, φ = B. Weights of the texels add up to
/// 1, and functions that are linear on a flat surface are reproduced, for then σ = B.
///
/// The thesis interpolates φ = σ on seam nodes and φ = B on all others by quadratics; a node at
/// distance d from a seam then costs 1/d energy per unit difference, without bound as d → 0. Here the
/// difference is spread over η instead.

#include <Eigen/Core>

#include <array>
#include <span>
#include <vector>

#include "mq/atlas/clip.h"
#include "mq/atlas/seams.h"
#include "mq/atlas/texel_grid.h"
#include "mq/fem/kernels/seam_kernels.h"

namespace mq {

/// The half-edges on seams near the cells of their chart.
class NearSeams {
 public:
  struct Entry {
    int chart, row, column;
    HalfEdge half_edge;
  };
  NearSeams(const Atlas& atlas, const Seams& seams);

  /// All entries of one row of cells, columns increasing.
  std::span<const Entry> row(int chart, int row) const;
  /// Those of one cell.
  static std::span<const Entry> cell(std::span<const Entry> row, int column);
  std::span<const Entry> cell(int chart, int row, int column) const {
    return cell(this->row(chart, row), column);
  }

 private:
  std::vector<Entry> entries_;
  std::vector<int> chart_offsets_;
};

/// Basis functions at points of one cell. Row q of the matrices is a point, column k a texel.
struct BasisSamples {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<int> texels;      ///< numbers of TexelGrid
  std::vector<int> triangles;   ///< per point
  std::vector<double> weights;  ///< per point, area in texels²
  std::vector<std::array<double, 2>> places;  ///< per point, in the cell
  Matrix values, dx, dy;        ///< derivatives per texel of x and y
};

/// Points of one cell of one chart, collected and then evaluated together. An object is used for
/// one cell after another, by one thread.
class SeamCell {
 public:
  using Polygon = std::vector<std::array<double, 2>>;

  SeamCell(const Atlas& atlas, const Seams& seams, const TexelGrid& grid)
      : atlas_(atlas), seams_(seams), grid_(grid) {}

  /// Begins anew. `near`: the entries of this cell and chart; none: the functions are bilinear.
  void start(int texture, int column, int row, std::span<const NearSeams::Entry> near);

  void add_point(int triangle, double x, double y, double weight);

  /// Adds points that integrate over a piece. Its sides on seams are cut wherever either side of
  /// the seam crosses a texel line, and it is parted along the lines at distance η from the seams
  /// near it, where λ has its kinks (unless these are many, and the piece then small). Parts in
  /// which no seam is within η are appended to `bilinear`; the others are fanned from their
  /// centroid, with a rule exact to degree 4 on each triangle.
  void add_piece(int triangle, const Piece& piece, std::vector<Polygon>& bilinear);

  bool empty() const { return triangles_.empty(); }

  std::size_t point_count() const { return triangles_.size(); }

  /// The points added since `start`, from number `first` on: all, or the first of them that do not
  /// have more than `most_texels` texels together (one point at least). Where the other side of a
  /// seam is stretched, a cell couples to hundreds, but each point to a few. Returns one past the
  /// last.
  std::size_t evaluate(BasisSamples& samples, std::size_t first = 0,
                       std::size_t most_texels = std::size_t(-1));

  /// Of the same points the upper triangles of mass and stiffness, by rows.
  struct Matrices {
    std::size_t end = 0;      ///< one past the last of the points
    std::vector<int> texels;  ///< numbers of TexelGrid
    std::vector<double> mass, stiffness;
  };
  void integrate(const std::vector<TexelMetric>& metrics, std::size_t first, std::size_t most_texels,
                 Matrices& matrices);

 private:
  using Segment = SeamSegment;
  struct Curve {  // σ − B along one seam between two breaks, quadratic in s − middle
    int segment;
    double begin, end, middle;
    int first_entry, end_entry;
  };
  struct CurveEntry {
    int texel;
    double c0, c1, c2;
  };
  using Term = SeamCurveTerm;
  bool reaches(const Polygon& polygon) const;
  int curve_at(int segment, double s);
  void weigh_points();
  void spread_curves(std::size_t stride);
  void add_bilinear(const SeamTerm& term);
  int texel(int number);
  template <class Visit>
  void for_each_texel(std::size_t point, const Visit& visit) const;
  std::size_t choose_texels(std::size_t first, std::size_t most_texels, std::vector<int>& chosen);
  Polygon outline(int triangle, const Piece& piece) const;

  const Atlas& atlas_;
  const Seams& seams_;
  const TexelGrid& grid_;
  std::array<int, 4> corner_{};  // index of the cell's corners in texels_
  std::vector<Segment> segments_;
  std::vector<HalfEdge> half_edges_;  // of the segments
  std::vector<Curve> curves_;
  std::vector<CurveEntry> entries_;
  std::vector<Term> terms_;
  std::vector<int> triangles_;  // of points
  std::vector<double> x_, y_, weights_;
  std::vector<int> first_terms_;  // of the points that are weighed; and one past the last of all
  std::vector<SeamWeights> near_;
  std::vector<int> texels_;
  std::vector<int> local_;  ///< per entry of texels_ its column in the samples, or -1
  std::vector<SeamTerm> value_;
  std::vector<double> spread_, scales_, room_;  // of `integrate`
};

}  // namespace mq
