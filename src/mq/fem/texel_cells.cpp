// Triangles are cut in bands of rows, each band by itself, and the bands joined in their order; integrals of
// pieces are in cell_integrals.cpp, seam blocks by detail/seam_basis.h.

#include "mq/fem/texel_cells.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "mq/base/parallel.h"
#include "mq/base/release.h"

namespace mq {

// ------------------------------------------------------------------------------------------ bands

namespace {

/// Cells of a band of rows of one texture; bands are the unit of parallel work.
struct Band {
  int texture, first_row, end_row;  // rows of cells as TexelGrid counts them
  std::vector<int> triangles;
  std::vector<CellIntegrals> cut;
  std::vector<TexelCells::CutInfo> info;
  SeamBlocks blocks;
};

struct PendingPiece {
  int chart, triangle;
  Piece piece;
};

constexpr int cells_per_band = 16384;

std::vector<Band> make_bands(const Surface& surface, const Atlas& atlas, const TexelGrid& grid) {
  std::vector<Band> bands;
  std::vector<int> first_band, rows_per_band;
  for (int k = 0; k < grid.texture_count(); ++k) {
    first_band.push_back(int(bands.size()));
    rows_per_band.push_back(std::clamp(cells_per_band / (grid.texture(k).width + 1), 1, 256));
    for (int row = 0; row < grid.cell_rows(k); row += rows_per_band[k])
      bands.push_back(
          {k, row, std::min(row + rows_per_band[k], grid.cell_rows(k)), {}, {}, {}, {}});
  }
  for (int t = 0; t < int(atlas.chart.size()); ++t) {
    if (atlas.chart[t] < 0) continue;
    const int texture = surface.mesh.texture(t), height = grid.texture(texture).height;
    const auto [first, end] = rows_of(atlas.corners[t]);
    const auto band_of = [&](int row) {
      return first_band[texture] + grid.cell_row(texture, row) / rows_per_band[texture];
    };
    const auto add = [&](int from, int to) {
      for (int b = from; b <= to; ++b)
        if (bands[b].triangles.empty() || bands[b].triangles.back() != t)
          bands[b].triangles.push_back(t);
    };
    const int from = band_of(first), to = band_of(end - 1);
    if (grid.texture(texture).wrap != Wrap::repeat ||
        (end - first < height && from <= to &&
         grid.cell_row(texture, first) <= grid.cell_row(texture, end - 1))) {
      add(from, to);
      continue;
    }
    // Around the border of a texture that repeats, or all of it.
    const int last = first_band[texture] + (grid.cell_rows(texture) - 1) / rows_per_band[texture];
    add(first_band[texture], end - first < height ? to : last);
    if (end - first < height) add(from, last);
  }
  return bands;
}

class BandIntegrator {
 public:
  BandIntegrator(const Surface& surface, const Atlas& atlas,
                 const std::vector<TexelMetric>& metrics, const TexelGrid& grid, const Seams* seams,
                 const NearSeams* near, std::span<const char> wanted, TexelCells& cells, Band& band,
                 const Progress& progress)
      : surface_(surface),
        atlas_(atlas),
        metrics_(metrics),
        grid_(grid),
        seams_(seams),
        near_(near),
        wanted_(wanted),
        cells_(cells),
        band_(band),
        progress_(progress),
        triangles_(int(atlas.chart.size())) {}

  void run() {
    for (int t : band_.triangles) {
      const auto [first, end] = rows_of(atlas_.corners[t]);
      if (covers_texture_often(t, end - first))
        add_repeating(t, first, end);
      else
        for_rows(first, end, [&](int row) { add_row(t, row, [&](int from, int to) { add_run(t, row, from, to); }); });
    }
    add_seam_blocks();
  }

 private:
  /// visit(row) for the rows in [first, end) that are rows of this band, once wrapped.
  template <class Visit>
  void for_rows(int first, int end, const Visit& visit) const {
    const TextureSize& size = grid_.texture(band_.texture);
    if (size.wrap == Wrap::repeat) {
      const int from = std::max(band_.first_row, 1) - 1, to = band_.end_row - 1,
                period = size.height;
      const int before = first - from;  // tiles below the first row
      int tile = before >= 0 ? before / period : -((period - 1 - before) / period);
      for (; tile * period + from < end; ++tile)
        for (int row = std::max(first, tile * period + from);
             row < std::min(end, tile * period + to); ++row)
          visit(row);
      return;
    }
    // The first and the last row of cells hold all that lies beyond them.
    const int from = band_.first_row == 0 ? first : std::max(first, band_.first_row - 1);
    const int to = band_.end_row == size.height + 1 ? end : std::min(end, band_.end_row - 1);
    for (int row = from; row < to; ++row) visit(row);
  }

  /// Whether a triangle runs over a texture that repeats more than once.
  bool covers_texture_often(int t, int rows) const {
    const TextureSize& size = grid_.texture(band_.texture);
    if (size.wrap != Wrap::repeat) return false;
    const auto& p = atlas_.corners[t];
    const auto [left, right] = std::minmax({p[0].x, p[1].x, p[2].x});
    return rows > size.height || (right - left) / TexelPoint::one > size.width;
  }

  /// One row of cells: cut cells and those near seams are entered, runs of whole cells are handed to
  /// whole(first, last).
  template <class Whole>
  void add_row(int t, int row, const Whole& whole) {
    progress_.check();
    if (!wants_row(row)) return;
    const auto near =
        near_ ? near_->row(atlas_.chart[t], row) : std::span<const NearSeams::Entry>();
    clip_row(
        atlas_.corners[t], row,
        [&](const Piece& piece) {
          const double area = piece.area();
          if (area < smallest_piece || !wants(row, piece.column)) return;
          if (!near.empty() && !NearSeams::cell(near, piece.column).empty())
            return add_pending(t, piece, area);
          add_integrals(bernstein_moments(piece), metrics_[t],
                        cut_cell(t, row, piece.column, area, area));
        },
        [&](int, int first, int last) {
          auto entry = std::lower_bound(
              near.begin(), near.end(), first,
              [](const NearSeams::Entry& e, int column) { return e.column < column; });
          for (; entry != near.end() && entry->column <= last; ++entry) {
            if (entry->column < first) continue;  // another entry of the same cell
            if (first < entry->column) whole(first, entry->column - 1);
            if (wants(row, entry->column)) add_pending(t, whole_cell(row, entry->column), 1);
            first = entry->column + 1;
          }
          if (first <= last) whole(first, last);
        });
  }

  /// A triangle that covers cells of a repeating texture many times: how often it covers each whole
  /// is counted over all tiles, and entered once.
  void add_repeating(int t, int first, int end) {
    const int width = grid_.texture(band_.texture).width;
    std::vector<int> change(width + 1);  // of the count, from one column to the next
    int everywhere = 0, current = -1;    // the row of cells that is counted
    std::vector<int> rows;
    for_rows(first, end, [&](int row) { rows.push_back(row); });
    const auto wrapped = [&](int row) { return grid_.cell_row(band_.texture, row); };
    std::stable_sort(rows.begin(), rows.end(),
                     [&](int p, int q) { return wrapped(p) < wrapped(q); });
    const auto flush = [&](int row) {
      for (int column = 0, count = everywhere; column < width; ++column) {
        count += change[column];
        if (count > 0) add_whole(t, row, column, count);
      }
      std::fill(change.begin(), change.end(), 0);
      everywhere = 0;
    };
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (k > 0 && wrapped(rows[k]) != current) flush(rows[k - 1]);
      current = wrapped(rows[k]);
      add_row(t, rows[k], [&](int from, int to) {
        everywhere += (to - from + 1) / width;
        const int rest = (to - from + 1) % width;
        if (rest == 0) return;
        const int begin = grid_.cell_column(band_.texture, from) - 1;
        ++change[begin];
        if (begin + rest <= width) {
          --change[begin + rest];
        } else {
          ++change[0];
          --change[begin + rest - width];
        }
      });
    }
    if (!rows.empty()) flush(rows.back());
  }

  void add_pending(int t, const Piece& piece, double area) {
    cut_cell(t, piece.row, piece.column, area, area);
    pending_.push_back({atlas_.chart[t], t, piece});
  }

  bool wants(int row, int column) const {
    return wanted_.empty() || wanted_[std::size_t(grid_.cell(band_.texture, column, row))] != 0;
  }

  /// Of a row of cells, whether any is wanted.
  bool wants_row(int row) const {
    if (wanted_.empty()) return true;
    const std::size_t width = std::size_t(grid_.texture(band_.texture).width) + 1;
    const auto cells = wanted_.subspan(std::size_t(grid_.cell(band_.texture, 0, row) - 1), width);
    return std::ranges::find(cells, 1) != cells.end();
  }

  void add_run(int t, int row, int from, int to) {
    if (!wanted_.empty() && grid_.texture(band_.texture).wrap != Wrap::repeat) {
      // What lies beyond the texture is in its outermost cells, or is left out with these.
      if (!wants(row, -1)) from = std::max(from, 0);
      if (const int last = grid_.texture(band_.texture).width - 1; !wants(row, last)) to = std::min(to, last - 1);
    }
    for (int column = from; column <= to; ++column) add_whole(t, row, column, 1);
  }

  /// The whole cell, `count` times.
  void add_whole(int t, int row, int column, int count) {
    if (!wants(row, column)) return;
    int& kind = cells_.kind[grid_.cell(band_.texture, column, row)];
    if (kind < 0 && count == 1) {
      kind = t;
      return;
    }
    const CellIntegrals& whole = cells_.whole[t];
    CellIntegrals& cut = cut_cell(t, row, column, count, 1);
    for (int k = 0; k < 9; ++k) cut.mass[k] += count * whole.mass[k];
    for (int k = 0; k < 6; ++k) cut.stiffness[k] += count * whole.stiffness[k];
  }

  /// A cut cell, made if need be, with pieces of `area` together, none larger than `largest`,
  /// entered in its info.
  CellIntegrals& cut_cell(int t, int row, int column, double area, double largest) {
    int& kind = cells_.kind[grid_.cell(band_.texture, column, row)];
    if (kind < triangles_) {
      const int covered_by = kind;
      kind = triangles_ + int(band_.cut.size());
      band_.cut.push_back(covered_by < 0 ? CellIntegrals() : cells_.whole[covered_by]);
      band_.info.push_back(covered_by < 0 ? TexelCells::CutInfo()
                                          : TexelCells::CutInfo{
                                                1, metrics_[covered_by].density, 1, covered_by, false});
    }
    TexelCells::CutInfo& info = band_.info[kind - triangles_];
    info.coverage += area;
    info.surface += area * metrics_[t].density;
    if (info.triangle >= 0 && atlas_.chart[info.triangle] != atlas_.chart[t]) info.several = true;
    if (tells_more(atlas_, float(largest), t, info.largest, info.triangle)) {
      info.largest = float(largest);
      info.triangle = t;
    }
    return band_.cut[kind - triangles_];
  }

  void add_mean(const PendingPiece& pending, SeamBlocks::CellMean& mean) const {
    const TexelMetric& metric = metrics_[pending.triangle];
    const double area = pending.piece.area();
    mean.surface += area * metric.density;
    mean.metric[0] += area * metric.a;
    mean.metric[1] += area * metric.b;
    mean.metric[2] += area * metric.c;
  }

  void add_seam_blocks() {
    if (pending_.empty()) return;
    const auto key = [](const PendingPiece& p) {
      return std::tuple(p.chart, p.piece.row, p.piece.column);
    };
    std::stable_sort(pending_.begin(), pending_.end(),
                     [&](const auto& p, const auto& q) { return key(p) < key(q); });
    SeamCell cell(atlas_, *seams_, grid_);
    SeamCell::Matrices matrices;
    std::vector<SeamCell::Polygon> bilinear;
    for (std::size_t begin = 0, end; begin < pending_.size(); begin = end) {
      const Piece& first = pending_[begin].piece;
      const int chart = pending_[begin].chart;
      const int number = grid_.cell(band_.texture, first.column, first.row);
      cell.start(band_.texture, first.column, first.row,
                 near_->cell(chart, first.row, first.column));
      SeamBlocks::CellMean& mean = band_.blocks.means.emplace_back(SeamBlocks::CellMean{number});
      for (end = begin; end < pending_.size() && key(pending_[end]) == key(pending_[begin]);
           ++end) {
        bilinear.clear();
        add_mean(pending_[end], mean);
        cell.add_piece(pending_[end].triangle, pending_[end].piece, bilinear);
        for (const SeamCell::Polygon& polygon : bilinear)
          add_integrals(bernstein_moments(polygon), metrics_[pending_[end].triangle],
                        band_.cut[cells_.kind[number] - triangles_]);
      }
      constexpr std::size_t most_texels = 64;  // of a block, which holds all pairs of them
      for (std::size_t point = 0; point < cell.point_count(); point = matrices.end) {
        cell.integrate(metrics_, point, most_texels, matrices);
        add_seam_block(number, matrices);
      }
    }
  }

  void add_seam_block(int number, const SeamCell::Matrices& matrices) {
    SeamBlocks& blocks = band_.blocks;
    const auto append = [](const auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); };
    blocks.blocks.push_back({number, int(blocks.texels.size()), int(matrices.texels.size()),
                             std::int64_t(blocks.mass.size())});
    append(matrices.texels, blocks.texels);
    append(matrices.mass, blocks.mass);
    append(matrices.stiffness, blocks.stiffness);
  }

  const Surface& surface_;
  const Atlas& atlas_;
  const std::vector<TexelMetric>& metrics_;
  const TexelGrid& grid_;
  const Seams* seams_;
  const NearSeams* near_;
  const std::span<const char> wanted_;  ///< per cell of the grid; empty: all
  TexelCells& cells_;
  Band& band_;
  const Progress& progress_;
  const int triangles_;
  std::vector<PendingPiece> pending_;
};

/// Where a band's seam blocks go among those of all.
struct SeamPlace {
  std::size_t block, texel, value, mean;
};

void put(SeamBlocks& from, const SeamPlace& place, SeamBlocks& to) {
  for (std::size_t b = 0; b < from.blocks.size(); ++b) {
    SeamBlocks::Block block = from.blocks[b];
    block.first += int(place.texel);
    block.first_value += std::int64_t(place.value);
    to.blocks[place.block + b] = block;
  }
  std::copy(from.texels.begin(), from.texels.end(), to.texels.begin() + std::ptrdiff_t(place.texel));
  std::copy(from.mass.begin(), from.mass.end(), to.mass.begin() + std::ptrdiff_t(place.value));
  std::copy(from.stiffness.begin(), from.stiffness.end(), to.stiffness.begin() + std::ptrdiff_t(place.value));
  std::copy(from.means.begin(), from.means.end(), to.means.begin() + std::ptrdiff_t(place.mean));
  from = {};
}

/// Joins the results of the bands, in their order.
void join_bands(std::vector<Band>& bands, int triangles, const TexelGrid& grid, TexelCells& cells) {
  std::vector<std::size_t> offsets{0};
  std::vector<SeamPlace> places{{}};
  for (const Band& band : bands) {
    offsets.push_back(offsets.back() + band.cut.size());
    const SeamPlace& place = places.back();
    places.push_back({place.block + band.blocks.blocks.size(), place.texel + band.blocks.texels.size(),
                      place.value + band.blocks.mass.size(), place.mean + band.blocks.means.size()});
  }
  cells.cut.resize(offsets.back());
  cells.info.resize(offsets.back());
  cells.seams.blocks.resize(places.back().block);
  cells.seams.texels.resize(places.back().texel);
  cells.seams.mass.resize(places.back().value);
  cells.seams.stiffness.resize(places.back().value);
  cells.seams.means.resize(places.back().mean);
  parallel_for(
      std::ssize(bands),
      [&](std::int64_t b) {
        Band& band = bands[b];
        put(band.blocks, places[b], cells.seams);
        // In the order of cells, in which they are read.
        const int width = grid.texture(band.texture).width + 1;
        const int first = grid.first_cell(band.texture);
        std::size_t next = offsets[b];
        for (int c = first + band.first_row * width; c < first + band.end_row * width; ++c) {
          int& kind = cells.kind[c];
          if (kind < triangles) continue;
          cells.cut[next] = band.cut[kind - triangles];
          cells.info[next] = band.info[kind - triangles];
          kind = triangles + int(next++);
        }
        release(band.cut);
        release(band.info);
      },
      1);
}

}  // namespace

bool tells_more(const Atlas& atlas, float area, int triangle, float other_area, int other_triangle) {
  constexpr float as_large = 0.999F;  // copies differ by rounding
  if (triangle < 0 || other_triangle < 0) return triangle >= 0;
  const int turn = atlas.charts[atlas.chart[triangle]].turn;
  const int other_turn = atlas.charts[atlas.chart[other_triangle]].turn;
  if (turn < other_turn) return area >= as_large * other_area;
  if (turn > other_turn) return as_large * area > other_area;
  return area > other_area;
}

TexelCells integrate_cells(const Surface& surface, const Atlas& atlas,
                           const std::vector<TexelMetric>& metrics, const TexelGrid& grid,
                           const Seams* seams, const NearSeams* near, std::span<const char> wanted,
                           const Progress& progress) {
  const int triangles = int(atlas.chart.size());
  TexelCells cells;
  cells.kind.assign(grid.cell_count(), -1);
  cells.whole.resize(triangles);
  for (int t = 0; t < triangles; ++t)
    if (atlas.chart[t] >= 0) add_integrals(whole_moments(), metrics[t], cells.whole[t]);

  std::vector<Band> bands = make_bands(surface, atlas, grid);
  std::atomic<std::int64_t> done = 0;
  parallel_for(
      std::ssize(bands),
      [&](std::int64_t b) {
        BandIntegrator(surface, atlas, metrics, grid, seams, near, wanted, cells, bands[b], progress).run();
        progress.at(0.9 * double(++done) / double(bands.size()));
      },
      1);
  join_bands(bands, triangles, grid, cells);
  progress.at(1);
  return cells;
}

}  // namespace mq
