#pragma once
/// An atlas made ready to be walked: the cells between texels, each cut in two, and what lies where a chart ends in one.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"
#include "mq/mesh/surface.h"

namespace mq {

class AtlasBorders;

/// A place of a chart: a cell of `TraceAtlas`, and where in it, both from 0 to 1.
struct ChartPlace {
  int chart = -1;  ///< none: nowhere
  int cell = 0;
  double x = 0, y = 0;  ///< to the right and down

  bool operator==(const ChartPlace&) const = default;
};

/// The domain of `AtlasFlow`. A texel is a node; every cell between four is cut into two triangles along a diagonal
/// whose direction alternates like a chess board, as in `GridFlow`. No triangle is stored, nor is the mesh cut: of the
/// mesh nothing remains but the mean metric of each cell (`TexelSpace::cell_metrics`), so that how the surface is cut
/// into triangles does not matter, and the half-edges where charts end, in the cells they run through.
///
/// Cells have one numbering for all textures: with w texels in a row, cell (i, j) with −1 ≤ i, j is number
/// first + (j + 1)·(w + 2) + i + 1, and so is the node at its upper left corner. 29 bytes per texel of the
/// textures, and 120 for each cell that a border runs through.
class TraceAtlas {
 public:
  /// All must outlive the object.
  TraceAtlas(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
             const Progress& progress = {});
  ~TraceAtlas();
  TraceAtlas(TraceAtlas&&) noexcept;

  const TexelSpace& space() const { return *space_; }
  const AtlasBorders& borders() const { return *borders_; }

  /// One more than the largest number of a cell or node.
  int node_count() const { return int(unknowns_.size()); }
  /// The unknown at a node; −1: none.
  int unknown(int node) const { return unknowns_[std::size_t(node)]; }
  const TexelSpace::CellMetric& metric(int cell) const { return metrics_[std::size_t(cell)]; }
  /// Whether a chart covers some of it.
  bool covered(int cell) const { return metrics_[std::size_t(cell)].xx > 0; }
  /// From a cell's upper left node to its lower left one.
  int stride(int cell) const { return textures_[std::size_t(texture_of(cell))].stride; }

  enum class Side { left, top, right, bottom };
  /// The cell beyond a side; −1: the texture ends there.
  int beyond(int cell, Side side) const {
    if (flags_[std::size_t(cell)] & (left_flag << int(side))) return beyond_end(cell, side);
    const int step = side == Side::left || side == Side::right ? 1 : stride(cell);
    return side == Side::left || side == Side::top ? cell - step : cell + step;
  }
  /// 0: the diagonal runs from the upper left to the lower right; 1: the other one.
  int diagonal(int cell) const { return flags_[std::size_t(cell)] & 1; }
  /// Whether borders of charts run through the cell.
  bool bordered(int cell) const { return (flags_[std::size_t(cell)] & border_flag) != 0; }

  /// The cell at a place of a texture in texels, wrapped or clamped as the texture is, and the place in it.
  ChartPlace place(int chart, int texture, const Vector2& texel) const;
  /// The same with a column and row of cells given, and where in this cell.
  int cell(int texture, int column, int row) const;

  /// Where paths of texels begin, one per unknown.
  struct Starts {
    /// At the centre where a chart covers it; otherwise straight on over the border of its chart (`AtlasWalk`), or,
    /// where the surface ends there, at the border.
    std::vector<ChartPlace> places;
    std::vector<char> outside;  ///< 1 where no chart covers the centre
  };
  Starts starts() const;

  /// A signal of texels there, as `TexelSpace` has it: bilinear, and next to seams the same from both sides. Within the
  /// values it is made of.
  void value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const;
  /// The same without seams: bilinear between the corners of the cell, as hardware looks textures up. Several times
  /// faster next to them.
  void plain_value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const;
  /// As `value`, but by the cubic through 4 × 4 texels of Catmull and Rom where all of them lie in a chart and away from its
  /// borders, within the values of these: sharper, as a mean of four is a blur.
  void sharp_value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const;
  /// visit(unknown, weight) for the corners of its cell, as hardware looks them up.
  template <class Visit>
  void for_each_corner(const ChartPlace& at, const Visit& visit) const {
    const std::array<double, 4> weights{(1 - at.x) * (1 - at.y), at.x * (1 - at.y), (1 - at.x) * at.y, at.x * at.y};
    const int step = stride(at.cell);
    const std::array<int, 4> unknowns{unknown(at.cell), unknown(at.cell + 1), unknown(at.cell + step),
                                      unknown(at.cell + step + 1)};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
      if (unknowns[k] >= 0) sum += weights[k];
    for (std::size_t k = 0; k < 4; ++k)
      if (weights[k] > 0 && unknowns[k] >= 0) visit(unknowns[k], weights[k] / sum);
  }

  /// Both places of a point of a seam, from 0 to 1 along it.
  using SeamPlaces = std::function<std::pair<ChartPlace, ChartPlace>(double)>;
  /// visit(length, places) for all seams, with the length of their longer side in texels.
  void for_each_seam(const std::function<void(double, const SeamPlaces&)>& visit) const;

  /// visit(unknown, weight) for what a lookup (`value`) reads, weights of sum 1 where any is known.
  void for_each_read(const ChartPlace& at, const std::function<void(int, double)>& visit) const;

  /// The texture of a cell, and the place in texels of its picture.
  int texture(int cell) const { return texture_of(cell); }
  Vector2 texel(const ChartPlace& at) const;

  /// In space, to the accuracy of single precision.
  Vector3 position(const ChartPlace& at) const;

  /// Cells of all textures, as `TexelGrid` counts them.
  std::int64_t grid_cell_count() const {
    std::int64_t count = 0;
    for (const Texture& t : textures_) count += std::int64_t(t.width + 1) * (t.height + 1);
    return count;
  }
  /// Values per cell of `TexelGrid`, as a texel space has them, by the numbers of cells here; what no cell has is 0.
  template <class Value>
  std::vector<Value> by_cell(const std::vector<Value>& of_grid) const {
    std::vector<Value> result(unknowns_.size());
    std::size_t from = 0;
    for (const Texture& t : textures_)
      for (int j = 0; j <= t.height; ++j, from += std::size_t(t.width) + 1)
        std::copy_n(of_grid.begin() + std::ptrdiff_t(from), t.width + 1, result.begin() + t.first + j * t.stride);
    return result;
  }

 private:
  static constexpr unsigned char left_flag = 2, top_flag = 4, right_flag = 8, bottom_flag = 16, border_flag = 32,
                                 seam_flag = 64;
  struct Texture {
    int first = 0, width = 0, height = 0, stride = 0;
    bool repeats = false;
  };
  int texture_of(int cell) const { return textures_.size() == 1 ? 0 : find_texture(cell); }
  int find_texture(int cell) const;
  int beyond_end(int cell, Side side) const;
  void number_nodes(const Atlas& atlas);
  void mark_ends(const Texture& texture);
  void mark_borders();
  ChartPlace start(int unknown, int triangle) const;
  template <class Visit>
  void for_each_weight(const ChartPlace& at, const Visit& visit) const;

  const Surface* surface_;
  const Atlas* atlas_;
  const TexelSpace* space_;
  std::vector<Texture> textures_;
  std::vector<int> unknowns_;                      ///< per node
  std::vector<TexelSpace::CellMetric> metrics_;    ///< per cell
  std::vector<unsigned char> flags_;               ///< per cell
  std::unique_ptr<AtlasBorders> borders_;
};

}  // namespace mq
