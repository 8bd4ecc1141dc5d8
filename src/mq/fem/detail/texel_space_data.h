#pragma once
/// What a `TexelSpace` holds, shared by its sources: texel_space_setup.cpp finds out, what
/// texel_space.cpp and texel_space_fields.cpp make matrices and integrals from.

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/fem/texel_cells.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// A cell around a texel and which of its corners the texel is.
struct Incidence {
  int cell;
  int corner;
  std::array<int, 4> corners;  ///< texels of the grid
};

/// Position in CellIntegrals of entry (corner, corner).
inline constexpr int mass_at[4][4] = {{0, 1, 3, 4}, {1, 2, 4, 5}, {3, 4, 6, 7}, {4, 5, 7, 8}};
inline constexpr int stiffness_at[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

/// Where in the 3 × 3 texels around a texel, row by row, corner `other` of a cell is whose corner `own` it is.
constexpr int place_around(int own, int other) {
  return 1 - (own & 1) + (other & 1) + 3 * (1 - (own >> 1) + (other >> 1));
}

/// An entry of a row of a matrix.
struct RowTerm {
  int column;
  double value;
};

/// Some channels of a signal, few enough for registers.
template <int count>
class ChannelGroup {
 public:
  using Row = Eigen::Array<double, count, 1>;

  ChannelGroup(const Signal& signal, Eigen::Index first)
      : values_(signal.data() + first), first_(first), stride_(signal.cols()) {}

  Row operator()(std::int64_t i) const { return Row::Map(values_ + i * stride_); }
  void store(const Row& row, std::int64_t i, Signal& to) const {
    Row::Map(to.data() + i * stride_ + first_) = row;
  }

 private:
  const double* values_;
  Eigen::Index first_, stride_;
};

/// visit(group) for all channels, up to four at once.
template <class Visit>
void for_channel_groups(const Signal& signal, const Visit& visit) {
  Eigen::Index first = 0;
  for (; first + 3 < signal.cols(); first += 4) visit(ChannelGroup<4>(signal, first));
  switch (signal.cols() - first) {
    case 1: return visit(ChannelGroup<1>(signal, first));
    case 2: return visit(ChannelGroup<2>(signal, first));
    case 3: return visit(ChannelGroup<3>(signal, first));
  }
}

/// What a texel space holds. Set up by `TexelSpace`'s constructor in the order of the functions below.
struct TexelSpace::Data {
  const Surface& surface;
  const Atlas& atlas;
  std::vector<TexelMetric> metrics;
  TexelGrid grid;
  std::unique_ptr<Seams> seams;
  std::unique_ptr<NearSeams> near;
  TexelCells cells;
  std::vector<char> marked;  ///< cells that are there; empty: all
  Texels texels;
  std::vector<int> unknown;        ///< per texel of the grid its unknown, or -1
  std::vector<int> block_offsets;  ///< per unknown: its seam blocks ...
  struct Part {
    int block, index;  ///< ... and which of their texels it is
  };
  std::vector<Part> parts;
  std::vector<char> shared;  ///< per unknown: several charts read it
  struct Weak {
    int unknown;
    double texel_area;  ///< of the surface, where it lies
  };
  std::vector<Weak> weak;  ///< unknowns that hardly any point of the surface shows
  Defects defects;
  bool integrated = true;  ///< whether `cells` has its integrals
  struct RowPiece {
    Texels::Place first;
    int unknown;  ///< of the first
  };
  std::vector<RowPiece> packed_places;  ///< while texels are let go of: unknowns side by side in a picture; and one behind

  Data(const Surface& s, const Atlas& a) : surface(s), atlas(a), grid(a.textures) {}

  int triangles() const { return int(atlas.chart.size()); }
  bool active(int cell) const { return cells.kind[cell] >= 0; }
  const CellIntegrals& integrals(int cell) const {
    const int kind = cells.kind[cell];
    return kind < triangles() ? cells.whole[kind] : cells.cut[kind - triangles()];
  }
  /// What covers a cell of a kind that is active.
  TexelCells::CutInfo cut_info(int kind) const {
    return kind < triangles() ? TexelCells::CutInfo{1, metrics[kind].density, 1, kind, false}
                              : cells.info[kind - triangles()];
  }
  std::span<const Part> blocks_of(int i) const {
    return {parts.data() + block_offsets[i], std::size_t(block_offsets[i + 1] - block_offsets[i])};
  }

  /// The texels of the grid at the corners of a cell.
  std::array<int, 4> corners_of(int cell) const {
    int k = 0;
    while (k + 1 < grid.texture_count() && grid.first_cell(k + 1) <= cell) ++k;
    const int local = cell - grid.first_cell(k), width = grid.texture(k).width + 1;
    return grid.corners(k, local % width - 1, local / width - 1);
  }

  // Set-up, in this order.
  void integrate(const TexelSpaceOptions& options, const Progress& progress);
  TexelCells cells_with_integrals(const Progress& progress) const;
  void require_integrals() const;
  void require_places() const;
  void require_metrics() const;
  void add_soft_seams(double penalty);
  void number_texels();
  void place_texels();
  int find_chart(int i);
  void find_parts();
  double texel_area(int i) const;
  double mass_at_texel(int i) const;
  void find_weak();
  void list_defects();

  // Cells around texels.
  template <class Visit>
  void for_each_cell(const Texels::Place& at, const Visit& visit) const;
  template <class Visit>
  void for_each_inner_cell(const Texels::Place& at, const Visit& visit) const;
  /// Not at the border of its picture: its cells and the texels of these are around it and nowhere else.
  bool inner(const Texels::Place& at) const {
    const TextureSize& size = grid.texture(at.texture);
    return at.x > 0 && at.y > 0 && at.x < size.width - 1 && at.y < size.height - 1;
  }
  std::span<const NearSeams::Entry> near_row(int triangle, int row) const {
    return near ? near->row(atlas.chart[triangle], row) : std::span<const NearSeams::Entry>();
  }

  // Rows.
  /// Whether cells alone couple texel i, to the 3 × 3 texels around it at most.
  bool is_grid_row(int i) const { return inner(texels.places[i]) && blocks_of(i).empty(); }
  /// Of the texels around an inner one: those of the row above, and a picture's width on, of the next ones.
  const int* unknowns_around(const Texels::Place& at) const {
    return unknown.data() + grid.first_texel(at.texture) + (at.y - 1) * grid.texture(at.texture).width + at.x - 1;
  }
  template <class OfCell>
  std::array<double, 9> grid_weights(const Texels::Place& at, const OfCell& of_cell) const;
  /// What cells give a row of an inner texel: to each of the 3 × 3 texels around it, row by row, and which of these
  /// they couple.
  struct GridRow {
    std::array<double, 9> values{};
    std::array<bool, 9> coupled{};
  };
  GridRow grid_row(const Texels::Place& at, double a, double b, std::span<const float> conductivity) const;
  int row_size(int i) const;
  /// Where the rows of the matrices begin, and where the last ends.
  std::vector<int> row_starts() const;
  /// Row i of a·M + b·Σ c_e·S_e, columns increasing; no conductivity: c = 1. They hold until the same thread asks
  /// for another row.
  const std::vector<RowTerm>& terms_of_row(int i, double a, double b, std::span<const float> conductivity) const;
  void fill_grid_row(int i, double a, double b, std::span<const float> conductivity, int* columns,
                     double* values) const;
  template <class Visit>
  void for_each_block_coupling(int i, std::span<const float> conductivity, const Visit& visit) const;
  template <class Visit>
  void for_each_coupling(int i, std::span<const float> conductivity, const Visit& visit) const;
  template <class Group, class OfBlock>
  OverwrittenVector<double> block_products(const Group& group, const OfBlock& of_block) const;
  template <class OfCell, class OfBlock>
  Signal stiffness_product(std::span<const int> rows, const Signal& psi, const OfCell& of_cell,
                           const OfBlock& of_block) const;
  SparseMatrix assemble(double a, double b, std::span<const float> conductivity,
                        const Progress& progress) const;
  /// visit(i, j, weight) for the pairs that `regularised_system` couples besides, of those that A has.
  template <class Visit>
  void for_each_held(double a, double b, const Visit& visit) const;
  void hold_weak(double a, double b, SparseMatrix& A) const;
  void hold_weak(double a, double b, const StencilLayout& layout, SparseMatrix& irregular, StencilRows& A) const;
  /// The texels above and below texel i if that couples to its 3 × 3 neighbours and nothing else, else −1.
  std::array<int, 2> stencil_middles(int i) const;
  std::unique_ptr<SparseMatrix> irregular_rows(double a, double b, const StencilLayout& layout,
                                               const Progress& progress) const;
  void fill_stencils(double a, double b, const StencilLayout& layout, StencilRows& A) const;

  // Elements: the cells of the grid, then the seam blocks.
  int element_of_block(int block) const { return grid.cell_count() + block; }
  template <class Visit>
  void for_each_grid_cell(const Visit& visit) const;
  template <class Visit>
  void visit_block(const Part& part, const Visit& visit) const;
};

template <class Visit>
void TexelSpace::Data::for_each_inner_cell(const Texels::Place& at, const Visit& visit) const {
  const int width = grid.texture(at.texture).width;
  const int first_cell = grid.first_cell(at.texture) + at.y * (width + 1) + at.x;
  const int first_texel = grid.first_texel(at.texture) + (at.y - 1) * width + at.x - 1;
  const auto at_corner = [&](int corner) {
    const int dx = 1 - (corner & 1), dy = 1 - (corner >> 1), texel = first_texel + dy * width + dx;
    return Incidence{first_cell + dy * (width + 1) + dx, corner, {texel, texel + 1, texel + width, texel + width + 1}};
  };
  visit(at_corner(3)), visit(at_corner(2)), visit(at_corner(1)), visit(at_corner(0));
}

template <class Visit>
void TexelSpace::Data::for_each_cell(const Texels::Place& at, const Visit& visit) const {
  const TextureSize& size = grid.texture(at.texture);
  if (inner(at)) return for_each_inner_cell(at, visit);
  const bool clamped = size.wrap != Wrap::repeat;
  int columns[3][2], rows[3][2];  // cell column or row, and on which side of it the texel is
  const auto fill = [&](int(&list)[3][2], int i, int n) {
    int count = 0;
    if (clamped && i == 0) list[count][0] = -1, list[count++][1] = 0;
    list[count][0] = i - 1, list[count++][1] = 1;
    list[count][0] = i, list[count++][1] = 0;
    if (clamped && i == n - 1 && count < 3) list[count][0] = n - 1, list[count++][1] = 1;
    return count;
  };
  // A clamped texture of one column: cells -1 and 0, the texel on both sides of both.
  int extra_columns = 0, extra_rows = 0;
  const int column_count = fill(columns, at.x, size.width),
            row_count = fill(rows, at.y, size.height);
  if (clamped && size.width == 1) extra_columns = 1;
  if (clamped && size.height == 1) extra_rows = 1;
  for (int r = 0; r < row_count + extra_rows; ++r)
    for (int c = 0; c < column_count + extra_columns; ++c) {
      const int column = c < column_count ? columns[c][0] : 0,
                p = c < column_count ? columns[c][1] : 1;
      const int row = r < row_count ? rows[r][0] : 0, q = r < row_count ? rows[r][1] : 1;
      visit(Incidence{grid.cell(at.texture, column, row), p + 2 * q,
                      grid.corners(at.texture, column, row)});
    }
}

/// visit(j, mass, stiffness) for all texels of a block, of the row of one of them.
template <class Visit>
void TexelSpace::Data::visit_block(const Part& part, const Visit& visit) const {
  const SeamBlocks::Block& block = cells.seams.blocks[part.block];
  for (int k = 0; k < block.count; ++k) {
    const std::int64_t at =
        block.first_value +
        SeamBlocks::index(std::min(k, part.index), std::max(k, part.index), block.count);
    visit(cells.seams.texels[block.first + k], cells.seams.mass[at], cells.seams.stiffness[at]);
  }
}

/// visit(j, mass, stiffness) for the terms of row i that seam blocks have.
template <class Visit>
void TexelSpace::Data::for_each_block_coupling(int i, std::span<const float> conductivity,
                                               const Visit& visit) const {
  for (const Part& part : blocks_of(i)) {
    const double factor =
        conductivity.empty() ? 1 : conductivity[element_of_block(part.block)];
    visit_block(part, [&](int j, double m, double s) { visit(j, m, factor * s); });
  }
}

/// visit(j, mass, stiffness) for every term of row i; a j may come several times. Stiffness terms
/// of j = i from cells are left out: they are minus the sum of the others.
template <class Visit>
void TexelSpace::Data::for_each_coupling(int i, std::span<const float> conductivity,
                                         const Visit& visit) const {
  for_each_cell(texels.places[i], [&](const Incidence& at) {
    if (!active(at.cell)) return;
    const CellIntegrals& cell = integrals(at.cell);
    const double factor = conductivity.empty() ? 1 : conductivity[at.cell];
    for (int d = 0; d < 4; ++d) {
      const double s = d == at.corner ? 0 : factor * cell.stiffness[stiffness_at[at.corner][d]];
      visit(unknown[at.corners[d]], cell.mass[mass_at[at.corner][d]], s);
      if (d != at.corner) visit(i, 0, -s);
    }
  });
  for_each_block_coupling(i, conductivity, visit);
}

/// Σ of_cell(cell, corners)·S_cell of a grid row, but for the diagonal: row by row of the 3 × 3 texels.
template <class OfCell>
std::array<double, 9> TexelSpace::Data::grid_weights(const Texels::Place& at, const OfCell& of_cell) const {
  std::array<double, 9> weights{};
  for_each_inner_cell(at, [&](const Incidence& in) __attribute__((always_inline)) {
    if (!active(in.cell)) return;
    const CellIntegrals& cell = integrals(in.cell);
    const double factor = of_cell(in.cell, in.corners);
    for (int d = 0; d < 4; ++d)
      if (d != in.corner) weights[place_around(in.corner, d)] += factor * cell.stiffness[stiffness_at[in.corner][d]];
  });
  return weights;
}

/// S_block·ψ of every seam block times of_block(block), at the places of its texels among those of all blocks: every
/// value of a block is read once for two rows.
template <class Group, class OfBlock>
OverwrittenVector<double> TexelSpace::Data::block_products(const Group& group, const OfBlock& of_block) const {
  using Row = typename Group::Row;
  constexpr int channels = Row::SizeAtCompileTime;
  const SeamBlocks& all = cells.seams;
  OverwrittenVector<double> products;
  products.resize(all.texels.size() * channels);
  parallel_blocks(std::ssize(all.blocks), 256, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Row> values, sums;
    for (std::int64_t b = begin; b < end; ++b) {
      const SeamBlocks::Block& block = all.blocks[b];
      values.resize(std::size_t(block.count));
      sums.assign(std::size_t(block.count), Row::Zero());
      for (int k = 0; k < block.count; ++k) values[k] = group(all.texels[block.first + k]);
      const double* s = all.stiffness.data() + block.first_value;
      for (int i = 0; i < block.count; ++i) {
        ++s;  // of the diagonal: rows sum to 0
        Row sum = Row::Zero();
        for (int j = i + 1; j < block.count; ++j) {
          const Row flow = *s++ * (values[j] - values[i]);
          sum += flow;
          sums[j] -= flow;
        }
        sums[i] += sum;
      }
      const double factor = of_block(int(b));
      double* of_texel = products.data() + std::int64_t(block.first) * channels;
      for (int k = 0; k < block.count; ++k, of_texel += channels) Row::Map(of_texel) = factor * sums[k];
    }
  });
  return products;
}

/// These rows (none: all) of Σ of_cell(cell, corners)·S_cell·ψ + Σ of_block(block)·S_block·ψ, gathered
/// texel by texel.
template <class OfCell, class OfBlock>
Signal TexelSpace::Data::stiffness_product(std::span<const int> rows, const Signal& psi,
                                           const OfCell& of_cell, const OfBlock& of_block) const {
  require_integrals();
  const std::int64_t count = rows.empty() ? psi.rows() : std::ssize(rows);
  Signal result(count, psi.cols());
  for_channel_groups(psi, [&]<int channels>(const ChannelGroup<channels>& group) {
    using Row = typename ChannelGroup<channels>::Row;
    const OverwrittenVector<double> products =
        rows.empty() ? block_products(group, of_block) : OverwrittenVector<double>();
    parallel_for(count, [&](std::int64_t r) {
      const int i = rows.empty() ? int(r) : rows[std::size_t(r)];
      const auto own = group(i);
      Row sum = Row::Zero();
      if (is_grid_row(i)) {
        const std::array<double, 9> weights = grid_weights(texels.places[i], of_cell);
        const int* const around = unknowns_around(texels.places[i]);
        const int width = grid.texture(texels.places[i].texture).width;
        for (int n = 0; n < 9; ++n)
          if (weights[n] != 0) sum += weights[n] * (group(around[n / 3 * width + n % 3]) - own);
        return group.store(sum, r, result);
      }
      for_each_cell(texels.places[i], [&](const Incidence& at) {
        if (!active(at.cell)) return;
        const CellIntegrals& cell = integrals(at.cell);
        const double factor = of_cell(at.cell, at.corners);
        for (int k = 0; k < 4; ++k)
          if (k != at.corner)
            sum += factor * cell.stiffness[stiffness_at[at.corner][k]] *
                   (group(unknown[at.corners[k]]) - own);
      });
      for (const Part& part : blocks_of(i)) {
        if (rows.empty()) {
          const int place = cells.seams.blocks[part.block].first + part.index;
          sum += Row::Map(products.data() + std::int64_t(place) * channels);
          continue;
        }
        const double factor = of_block(part.block);
        visit_block(part, [&](int j, double, double s) {
          if (j != i) sum += factor * s * (group(j) - own);
        });
      }
      group.store(sum, r, result);
    });
  });
  return result;
}

template <class Visit>
void TexelSpace::Data::for_each_held(double a, double b, const Visit& visit) const {
  constexpr double tau = 1e-4;
  std::vector<double> area_of_weak(texels.size(), 0);  // else 0
  for (const Weak& one : weak) area_of_weak[one.unknown] = one.texel_area;
  for (const Weak& one : weak) {
    const int i = one.unknown;
    const Texels::Place& place = texels.places[i];
    for (int n = 0; n < 9; ++n) {
      const int j = unknown[grid.texel(place.texture, place.x + n % 3 - 1, place.y + n / 3 - 1)];
      if (j < 0 || j == i || (area_of_weak[j] > 0 && j < i)) continue;
      const double area =
          area_of_weak[j] > 0 ? (one.texel_area + area_of_weak[j]) / 2 : one.texel_area;
      visit(i, j, tau * (a * area + b));
    }
  }
}

/// visit(cell, corners) for every cell that a chart meets, in parallel over rows of cells.
template <class Visit>
void TexelSpace::Data::for_each_grid_cell(const Visit& visit) const {
  for (int k = 0; k < grid.texture_count(); ++k) {
    const int width = grid.texture(k).width + 1;
    parallel_for(
        grid.cell_rows(k),
        [&](std::int64_t row) {
          const int first = grid.first_cell(k) + int(row) * width;
          for (int column = 0; column < width; ++column)
            if (active(first + column))
              visit(first + column, grid.corners(k, column - 1, int(row) - 1));
        },
        16);
  }
}

}  // namespace mq
