// Matrices are gathered row by row from the integrals of the (at most four) cells around a texel
// and from the seam blocks it takes part in, so that rows are independent: any number of threads,
// one result. A row whose texel no seam touches is a 3 × 3 stencil and takes a path of its own.

#include "mq/fem/texel_space.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/quadrature.h"
#include "mq/fem/texel_cells.h"

namespace mq {
namespace {

/// Position in CellIntegrals of entry (corner, corner).
constexpr int mass_at[4][4] = {{0, 1, 3, 4}, {1, 2, 4, 5}, {3, 4, 6, 7}, {4, 5, 7, 8}};
constexpr int stiffness_at[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

/// A cell around a texel and which of its corners the texel is.
struct Incidence {
  int cell;
  int corner;
  std::array<int, 4> corners;  ///< texels of the grid
};

}  // namespace

struct TexelSpace::Data {
  const Surface& surface;
  const Atlas& atlas;
  std::vector<TexelMetric> metrics;
  TexelGrid grid;
  std::unique_ptr<Seams> seams;
  std::unique_ptr<NearSeams> near;
  TexelCells cells;
  Texels texels;
  std::vector<int> unknown;        ///< per texel of the grid its unknown, or -1
  std::vector<int> block_offsets;  ///< per unknown: its seam blocks ...
  struct Part {
    int block, index;  ///< ... and which of their texels it is
  };
  std::vector<Part> parts;
  std::vector<char> shared;      ///< per unknown: several charts read it
  std::vector<int> weak;         ///< unknowns that hardly any point of the surface shows
  std::vector<int> row_offsets;  ///< of the matrices
  Defects defects;

  Data(const Surface& s, const Atlas& a) : surface(s), atlas(a), grid(a.textures) {}

  int triangles() const { return int(atlas.chart.size()); }
  bool active(int cell) const { return cells.kind[cell] >= 0; }
  const CellIntegrals& integrals(int cell) const {
    const int kind = cells.kind[cell];
    return kind < triangles() ? cells.whole[kind] : cells.cut[kind - triangles()];
  }
  std::span<const Part> blocks_of(int i) const {
    return {parts.data() + block_offsets[i], std::size_t(block_offsets[i + 1] - block_offsets[i])};
  }

  // Set-up, in this order.
  void integrate(const TexelSpaceOptions& options, const Progress& progress);
  void add_soft_seams(double penalty);
  void number_texels();
  void place_texels();
  void find_parts();
  void find_weak();
  void count_rows();
  void list_defects();

  // Cells around texels.
  template <class Visit>
  void for_each_cell(const Texels::Place& at, const Visit& visit) const;
  bool inner(const Texels::Place& at) const;
  std::span<const NearSeams::Entry> near_row(int triangle, int row) const {
    return near ? near->row(atlas.chart[triangle], row) : std::span<const NearSeams::Entry>();
  }

  // Rows.
  int row_size(int i) const;
  void fill_row(int i, double a, double b, int* columns, double* values) const;
  template <class Visit>
  void for_each_coupling(int i, const Visit& visit) const;
  template <class Visit>
  void visit_block(const Part& part, const Visit& visit) const;
};

// ----------------------------------------------------------------------------------------- set-up

void TexelSpace::Data::integrate(const TexelSpaceOptions& options, const Progress& progress) {
  metrics = options.metrics;
  if (metrics.empty()) {
    metrics.resize(triangles());
    for (int t = 0; t < triangles(); ++t)
      if (atlas.chart[t] >= 0) metrics[t] = texel_metric(surface, atlas, t);
  }
  require(int(metrics.size()) == triangles(), "one metric per triangle is needed");
  seams = std::make_unique<Seams>(surface, atlas);
  near = std::make_unique<NearSeams>(atlas, *seams);
  progress.step("find seams", 0.1).at(1);
  const bool soft = options.seams == TexelSpaceOptions::Seams::soft;
  cells = integrate_cells(surface, atlas, metrics, grid, seams.get(), soft ? nullptr : near.get(),
                          progress.step("cut and integrate", 0.6));
  if (soft) {
    add_soft_seams(options.seam_penalty);
    near.reset();
  }
}

/// ∫ (φ_first − φ_second)² ds between consecutive breaks, where both sides are quadratic in s.
void TexelSpace::Data::add_soft_seams(double penalty) {
  const double gauss = std::sqrt(0.6) / 2;
  const double points[3] = {0.5 - gauss, 0.5, 0.5 + gauss},
               weights[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  SeamBlocks& blocks = cells.seams;
  std::vector<int> numbers;
  const auto index_of = [&](int number) {
    const auto at = std::find(numbers.begin(), numbers.end(), number);
    if (at == numbers.end()) return numbers.push_back(number), int(numbers.size()) - 1;
    return int(at - numbers.begin());
  };
  for (int e = 0; e < seams->count(); ++e) {
    const HalfEdge h = seams->half_edges(e)[0];
    const Mesh& mesh = surface.mesh;
    const double length =
        (mesh.position(h / 3, h % 3 == 2 ? 0 : h % 3 + 1) - mesh.position(h / 3, h % 3)).norm();
    const auto breaks = seams->breaks(e);
    for (std::size_t k = 1; k < breaks.size(); ++k) {
      numbers.clear();
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 24);  // 3 points, 2 sides, 4 texels each
      for (int q = 0; q < 3; ++q) {
        const double s = breaks[k - 1] + (breaks[k] - breaks[k - 1]) * points[q];
        const double scale = std::sqrt(penalty * length * (breaks[k] - breaks[k - 1]) * weights[q]);
        for (int side = 0; side < 2; ++side) {
          const TexturePlace p = seams->place(seams->half_edges(e)[side], s);
          const double w[4] = {(1 - p.x) * (1 - p.y), p.x * (1 - p.y), (1 - p.x) * p.y, p.x * p.y};
          for (int c = 0; c < 4; ++c)
            if (w[c] != 0)
              rows(q, index_of(grid.texel(p.texture, p.column + (c & 1), p.row + (c >> 1)))) +=
                  (side == 0 ? scale : -scale) * w[c];
        }
      }
      const int count = int(numbers.size());
      blocks.blocks.push_back(
          {-1, int(blocks.texels.size()), count, std::int64_t(blocks.mass.size())});
      blocks.texels.insert(blocks.texels.end(), numbers.begin(), numbers.end());
      const Eigen::MatrixXd S = rows.leftCols(count).transpose() * rows.leftCols(count);
      for (int i = 0; i < count; ++i)
        for (int j = i; j < count; ++j) {
          blocks.mass.push_back(0);
          blocks.stiffness.push_back(S(i, j));
        }
    }
  }
}

template <class Visit>
void TexelSpace::Data::for_each_cell(const Texels::Place& at, const Visit& visit) const {
  const TextureSize& size = grid.texture(at.texture);
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

bool TexelSpace::Data::inner(const Texels::Place& at) const {
  const TextureSize& size = grid.texture(at.texture);
  return at.x > 0 && at.y > 0 && at.x < size.width - 1 && at.y < size.height - 1;
}

void TexelSpace::Data::number_texels() {
  unknown.assign(grid.texel_count(), -1);
  for (int t : cells.seams.texels) unknown[t] = 0;
  std::vector<Texels::Place> starts;  // of rows
  for (int k = 0; k < grid.texture_count(); ++k)
    for (int y = 0; y < grid.texture(k).height; ++y) starts.push_back({k, 0, y});
  std::vector<int> offsets(starts.size() + 1, 0);
  parallel_for(
      std::ssize(starts),
      [&](std::int64_t r) {
        Texels::Place at = starts[r];
        const int width = grid.texture(at.texture).width;
        int* row = unknown.data() + grid.texel(at.texture, 0, at.y);
        for (; at.x < width; ++at.x) {
          for_each_cell(at, [&](const Incidence& i) {
            if (active(i.cell)) row[at.x] = 0;
          });
          offsets[r + 1] += row[at.x] == 0;
        }
      },
      16);
  for (std::size_t r = 1; r < offsets.size(); ++r) offsets[r] += offsets[r - 1];
  texels.places.resize(offsets.back());
  parallel_for(
      std::ssize(starts),
      [&](std::int64_t r) {
        Texels::Place at = starts[r];
        int* row = unknown.data() + grid.texel(at.texture, 0, at.y);
        int next = offsets[r];
        for (; at.x < grid.texture(at.texture).width; ++at.x)
          if (row[at.x] == 0) {
            texels.places[next] = at;
            row[at.x] = next++;
          }
      },
      16);
}

/// The surface's affine map of one triangle, continued to a place in its chart at most a texel or
/// so away; where the triangle itself is smaller than a texel, to its nearest corner instead.
std::array<float, 3> position_near(const Surface& surface, const Atlas& atlas, int triangle,
                                   double x, double y) {
  const auto& p = atlas.corners[triangle];
  const double x0 = p[0].column(), y0 = p[0].row();
  const double ux = p[1].column() - x0, uy = p[1].row() - y0;
  const double vx = p[2].column() - x0, vy = p[2].row() - y0;
  const double det = ux * vy - uy * vx;
  double l1 = ((x - x0) * vy - (y - y0) * vx) / det;
  double l2 = (ux * (y - y0) - uy * (x - x0)) / det;
  constexpr double reach = 2;
  const double outside = std::max({-l1, -l2, l1 + l2 - 1});
  if (!(outside < reach)) l1 = std::clamp(l1, 0.0, 1.0), l2 = std::clamp(l2, 0.0, 1.0 - l1);
  const Mesh& mesh = surface.mesh;
  const Vector3 at = mesh.position(triangle, 0) +
                     l1 * (mesh.position(triangle, 1) - mesh.position(triangle, 0)) +
                     l2 * (mesh.position(triangle, 2) - mesh.position(triangle, 0));
  return {float(at.x()), float(at.y()), float(at.z())};
}

void TexelSpace::Data::place_texels() {
  const int n = int(texels.places.size());
  texels.positions.assign(n, {0, 0, 0});
  texels.chart.assign(n, -1);
  texels.interior.assign(n, 0);
  shared.assign(n, 0);
  parallel_for(n, [&](std::int64_t i) {
    const Texels::Place& at = texels.places[i];
    int best = -1;
    float area = -1;
    bool whole = inner(at) && blocks_of(int(i)).empty();
    for_each_cell(at, [&](const Incidence& c) {
      const int kind = cells.kind[c.cell];
      if (kind < 0) {
        whole = false;
        return;
      }
      const TexelCells::CutInfo info = kind < triangles() ? TexelCells::CutInfo{1, 1, kind, false}
                                                          : cells.info[kind - triangles()];
      if (std::abs(info.coverage - 1) > 1e-5f) whole = false;
      const int chart = info.triangle < 0 ? -1 : atlas.chart[info.triangle];
      if (info.several || (texels.chart[i] >= 0 && chart >= 0 && chart != texels.chart[i]))
        shared[i] = 1;
      if (chart >= 0 && (texels.chart[i] < 0 || chart < texels.chart[i])) texels.chart[i] = chart;
      if (info.largest > area) area = info.largest, best = info.triangle;
    });
    if (best < 0) return;
    texels.interior[i] = whole && !shared[i];
    // The triangle's chart may lie whole textures away where the texture repeats.
    const TextureSize& size = atlas.textures[at.texture];
    double x = at.x, y = at.y;
    if (size.wrap == Wrap::repeat) {
      const TexelPoint& p = atlas.corners[best][0];
      x += std::round((p.column() - x) / size.width) * size.width;
      y += std::round((p.row() - y) / size.height) * size.height;
    }
    texels.positions[i] = position_near(surface, atlas, best, x, y);
  });
}

void TexelSpace::Data::find_parts() {
  SeamBlocks& blocks = cells.seams;
  for (int& t : blocks.texels) t = unknown[t];
  block_offsets.assign(texels.places.size() + 1, 0);
  for (int i : blocks.texels) ++block_offsets[i + 1];
  for (std::size_t i = 1; i < block_offsets.size(); ++i) block_offsets[i] += block_offsets[i - 1];
  parts.resize(blocks.texels.size());
  std::vector<int> next(block_offsets.begin(), block_offsets.end() - 1);
  for (int b = 0; b < int(blocks.blocks.size()); ++b)
    for (int k = 0; k < blocks.blocks[b].count; ++k)
      parts[next[blocks.texels[blocks.blocks[b].first + k]]++] = {b, k};
}

void TexelSpace::Data::find_weak() {
  constexpr double hardly_seen = 1e-3;
  std::vector<char> is_weak(texels.size());
  const double texel_area = atlas.surface_area / atlas.texel_area;
  parallel_for(texels.size(), [&](std::int64_t i) {
    if (texels.interior[i]) return;
    double diagonal = 0;
    for_each_coupling(int(i), [&](int j, double m, double) { diagonal += j == i ? m : 0; });
    is_weak[i] = diagonal < hardly_seen * texel_area;
  });
  for (int i = 0; i < texels.size(); ++i)
    if (is_weak[i]) weak.push_back(i);
}

void TexelSpace::Data::list_defects() {
  std::vector<std::int64_t> overlapping, several;
  for (int k = 0; k < grid.texture_count(); ++k) {
    const int width = grid.texture(k).width + 1, first = grid.first_cell(k);
    for (int c = first; c < first + width * grid.cell_rows(k); ++c) {
      if (cells.kind[c] < triangles()) continue;
      if (cells.info[cells.kind[c] - triangles()].coverage <= 1.001f) continue;
      const int local = c - first;
      overlapping.push_back(grid.texel(k, local % width - 1, local / width - 1));
    }
  }
  for (int i = 0; i < texels.size(); ++i)
    if (shared[i])
      several.push_back(
          grid.texel(texels.places[i].texture, texels.places[i].x, texels.places[i].y));
  shared = {};
  const auto add = [&](const char* kind, const std::vector<std::int64_t>& all,
                       const char* message) {
    if (all.empty()) return;
    Defect defect{kind, Defect::Severity::warning, "texel", std::int64_t(all.size()), {}, message};
    defect.ids.assign(all.begin(),
                      all.begin() + std::min<std::ptrdiff_t>(std::ssize(all), Defect::max_ids));
    defects.push_back(std::move(defect));
  };
  add("overlapping_triangles", overlapping,
      "cells that triangles cover more than once (ids: texel at the left top, counted row by row): "
      "the "
      "places of the surface there share one colour; unwrap them apart to treat them apart");
  add("shared_texels", several,
      "texels that several charts read (ids counted row by row): charts nearer than a texel's "
      "footprint share it, so values leak between them; a wider gutter or a larger texture parts "
      "them");
}

// ------------------------------------------------------------------------------------------- rows

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

/// visit(j, mass, stiffness) for every term of row i; a j may come several times. Stiffness terms
/// of j = i from cells are left out: they are minus the sum of the others.
template <class Visit>
void TexelSpace::Data::for_each_coupling(int i, const Visit& visit) const {
  for_each_cell(texels.places[i], [&](const Incidence& at) {
    if (!active(at.cell)) return;
    const CellIntegrals& cell = integrals(at.cell);
    for (int d = 0; d < 4; ++d) {
      const double s = d == at.corner ? 0 : cell.stiffness[stiffness_at[at.corner][d]];
      visit(unknown[at.corners[d]], cell.mass[mass_at[at.corner][d]], s);
      if (d != at.corner) visit(i, 0, -s);
    }
  });
  for (const Part& part : blocks_of(i)) visit_block(part, visit);
}

namespace {

struct Term {
  int column;
  double value;
};

/// Adds to the term of the same column, if there is one: rows are short.
void add_term(std::vector<Term>& terms, int column, double value) {
  for (Term& term : terms)
    if (term.column == column) return void(term.value += value);
  terms.push_back({column, value});
}

}  // namespace

int TexelSpace::Data::row_size(int i) const {
  const Texels::Place& at = texels.places[i];
  if (inner(at) && blocks_of(i).empty()) {
    const int width = grid.texture(at.texture).width + 1;
    const int* cell = cells.kind.data() + grid.cell(at.texture, at.x - 1, at.y - 1);
    const bool c00 = cell[0] >= 0, c10 = cell[1] >= 0, c01 = cell[width] >= 0,
               c11 = cell[width + 1] >= 0;
    return 1 + c00 + c10 + c01 + c11 + (c00 || c10) + (c01 || c11) + (c00 || c01) + (c10 || c11);
  }
  thread_local std::vector<Term> terms;
  terms.clear();
  for_each_coupling(i, [&](int j, double, double) { add_term(terms, j, 0); });
  return int(terms.size());
}

void TexelSpace::Data::fill_row(int i, double a, double b, int* columns, double* values) const {
  const Texels::Place& at = texels.places[i];
  if (!inner(at) || !blocks_of(i).empty()) {
    thread_local std::vector<Term> terms;
    terms.clear();
    for_each_coupling(i, [&](int j, double m, double s) { add_term(terms, j, a * m + b * s); });
    std::sort(terms.begin(), terms.end(),
              [](const Term& p, const Term& q) { return p.column < q.column; });
    for (std::size_t k = 0; k < terms.size(); ++k)
      columns[k] = terms[k].column, values[k] = terms[k].value;
    return;
  }
  double sums[9] = {};
  bool coupled[9] = {};
  const TextureSize& size = grid.texture(at.texture);
  const int first = grid.first_cell(at.texture) + at.y * (size.width + 1) + at.x;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const int id = first + dy * (size.width + 1) + dx;
      if (!active(id)) continue;
      const CellIntegrals& cell = integrals(id);
      const int corner = 3 - dx - 2 * dy, origin = dx + 3 * dy;
      double diagonal = 0;
      for (int d = 0; d < 4; ++d) {
        const int place = origin + (d & 1) + 3 * (d >> 1);
        coupled[place] = true;
        sums[place] += a * cell.mass[mass_at[corner][d]];
        if (d == corner) continue;
        const double s = b * cell.stiffness[stiffness_at[corner][d]];
        sums[place] += s;
        diagonal -= s;
      }
      sums[4] += diagonal;
    }
  const int* around =
      unknown.data() + grid.first_texel(at.texture) + (at.y - 1) * size.width + at.x - 1;
  for (int place = 0; place < 9; ++place)
    if (coupled[place]) {
      *columns++ = around[place / 3 * size.width + place % 3];
      *values++ = sums[place];
    }
}

void TexelSpace::Data::count_rows() {
  const int n = texels.size();
  std::vector<int> sizes(n);
  parallel_for(
      n, [&](std::int64_t i) { sizes[i] = row_size(int(i)); }, 4096);
  row_offsets.assign(n + 1, 0);
  std::int64_t sum = 0;
  for (int i = 0; i < n; ++i) {
    sum += sizes[i];
    require(sum < INT32_MAX,
            fmt::format("the {} texels that the charts use make a system of more than 2^31 entries "
                        "(texels couple to 8 others): use smaller textures",
                        n));
    row_offsets[i + 1] = int(sum);
  }
}

// ----------------------------------------------------------------------------------------- public

TexelSpace::TexelSpace(const Surface& surface, const Atlas& atlas, const TexelSpaceOptions& options,
                       const Progress& progress) {
  if (refused(atlas.defects)) {
    std::string message = "the atlas cannot be worked with:";
    for (const Defect& d : atlas.defects)
      if (d.severity == Defect::Severity::refused)
        message += fmt::format(
            " {} {}s ({}{}): {};", d.count, d.element,
            fmt::join(d.ids.begin(), d.ids.begin() + std::min<std::size_t>(d.ids.size(), 5), ", "),
            d.count > 5 ? ", ..." : "", d.message);
    message.pop_back();
    throw InvalidInput(message);
  }
  data_ = std::make_unique<Data>(surface, atlas);
  data_->integrate(options, progress);
  data_->number_texels();
  require(!data_->texels.places.empty(),
          "no triangle has texture coordinates and area: there is nothing to work on");
  progress.at(0.75);
  data_->find_parts();
  data_->count_rows();
  progress.at(0.85);
  data_->place_texels();
  data_->find_weak();
  data_->list_defects();
  progress.at(1);
}

TexelSpace::~TexelSpace() = default;
TexelSpace::TexelSpace(TexelSpace&&) noexcept = default;

int TexelSpace::size() const { return data_->texels.size(); }
const Texels& TexelSpace::texels() const { return data_->texels; }
const Defects& TexelSpace::defects() const { return data_->defects; }

SurfaceScale TexelSpace::scale() const {
  return {data_->atlas.surface_area, data_->atlas.texel_spacing()};
}

SparseMatrix TexelSpace::system(double a, double b, const Progress& progress) const {
  const int n = size();
  SparseMatrix matrix(n, n);
  matrix.resizeNonZeros(data_->row_offsets.back());
  std::copy(data_->row_offsets.begin(), data_->row_offsets.end(), matrix.outerIndexPtr());
  parallel_blocks(n, 4096, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t i = begin; i < end; ++i) {
      const int at = data_->row_offsets[i];
      data_->fill_row(int(i), a, b, matrix.innerIndexPtr() + at, matrix.valuePtr() + at);
    }
  });
  return matrix;
}

SparseMatrix TexelSpace::solvable(double a, double b, const Progress& progress) const {
  constexpr double tau = 1e-4;
  SparseMatrix A = system(a, b, progress);
  const Data& d = *data_;
  const double weight = tau * (a * d.atlas.surface_area / d.atlas.texel_area + b);
  std::vector<char> is_weak(size());
  for (int i : d.weak) is_weak[i] = 1;
  const auto entry_of = [&](int i, int j) {
    const int* const columns = A.innerIndexPtr();
    const int* const end = columns + A.outerIndexPtr()[i + 1];
    const int* const at = std::lower_bound(columns + A.outerIndexPtr()[i], end, j);
    return at != end && *at == j ? A.valuePtr() + (at - columns) : nullptr;
  };
  for (int i : d.weak) {
    const Texels::Place& place = d.texels.places[i];
    for (int n = 0; n < 9; ++n) {
      const int j =
          d.unknown[d.grid.texel(place.texture, place.x + n % 3 - 1, place.y + n / 3 - 1)];
      if (j < 0 || j == i || (is_weak[j] && j < i)) continue;
      double* const coupling = entry_of(i, j);
      if (!coupling) continue;
      *coupling -= weight;
      *entry_of(j, i) -= weight;
      *entry_of(i, i) += weight;
      *entry_of(j, j) += weight;
    }
  }
  return A;
}

Signal TexelSpace::stiffness_times(const Signal& psi, std::span<const double> beta) const {
  require(psi.rows() == size(), "one row per texel is needed");
  require(beta.empty() || std::ssize(beta) == size(), "one modulation per texel is needed");
  const Data& d = *data_;
  Signal result = Signal::Zero(psi.rows(), psi.cols());
  const auto mean_beta = [&](const std::array<int, 4>& corners) {
    if (beta.empty()) return 1.0;
    double sum = 0;
    for (int c : corners) sum += beta[d.unknown[c]];
    return sum / 4;
  };
  // Of a seam block: the corners of the cell whose pieces it holds.
  const auto block_beta = [&](const SeamBlocks::Block& block) {
    if (beta.empty()) return 1.0;
    if (block.cell < 0) {
      double sum = 0;
      for (int k = 0; k < block.count; ++k) sum += beta[d.cells.seams.texels[block.first + k]];
      return sum / block.count;
    }
    int k = 0;
    while (k + 1 < d.grid.texture_count() && d.grid.first_cell(k + 1) <= block.cell) ++k;
    const int local = block.cell - d.grid.first_cell(k), width = d.grid.texture(k).width + 1;
    return mean_beta(d.grid.corners(k, local % width - 1, local / width - 1));
  };
  parallel_for(size(), [&](std::int64_t i) {
    d.for_each_cell(d.texels.places[i], [&](const Incidence& at) {
      if (!d.active(at.cell)) return;
      const CellIntegrals& cell = d.integrals(at.cell);
      const double modulation = mean_beta(at.corners);
      for (int k = 0; k < 4; ++k)
        if (k != at.corner)
          result.row(i) += modulation * cell.stiffness[stiffness_at[at.corner][k]] *
                           (psi.row(d.unknown[at.corners[k]]) - psi.row(i));
    });
    for (const Data::Part& part : d.blocks_of(int(i))) {
      const double modulation = block_beta(d.cells.seams.blocks[part.block]);
      d.visit_block(part, [&](int j, double, double s) {
        if (j != i) result.row(i) += modulation * s * (psi.row(j) - psi.row(i));
      });
    }
  });
  return result;
}

Signal TexelSpace::gather(std::span<const Image<float>> pictures) const {
  const Data& d = *data_;
  require(std::ssize(pictures) == d.grid.texture_count(),
          fmt::format("{} pictures for {} textures: give one each", pictures.size(),
                      d.grid.texture_count()));
  const int channels = pictures.front().channels();
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const TextureSize& size = d.grid.texture(k);
    if (pictures[k].width() != size.width || pictures[k].height() != size.height ||
        pictures[k].channels() != channels)
      throw InvalidInput(
          fmt::format("picture {} is {} x {} with {} channels where {} x {} with {} was wanted", k,
                      pictures[k].width(), pictures[k].height(), pictures[k].channels(), size.width,
                      size.height, channels));
  }
  Signal signal(size(), channels);
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < channels; ++c) signal(i, c) = pixel[c];
  });
  return signal;
}

void TexelSpace::scatter(const Signal& signal, std::span<Image<float>> pictures) const {
  const Data& d = *data_;
  require(signal.rows() == size() && std::ssize(pictures) == d.grid.texture_count() &&
              signal.cols() == pictures.front().channels(),
          "a signal of this space and the pictures it was gathered from are needed");
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < signal.cols(); ++c) pixel[c] = float(signal(i, c));
  });
}

std::int64_t TexelSpace::bytes() const {
  const Data& d = *data_;
  const auto size = [](const auto& v) { return std::int64_t(v.capacity() * sizeof(v[0])); };
  return size(d.metrics) + size(d.cells.kind) + size(d.cells.cut) + size(d.cells.info) +
         size(d.cells.whole) + size(d.cells.seams.blocks) + size(d.cells.seams.texels) +
         size(d.cells.seams.mass) + size(d.cells.seams.stiffness) + size(d.texels.places) +
         size(d.texels.positions) + size(d.texels.chart) + size(d.texels.interior) +
         size(d.unknown) + size(d.block_offsets) + size(d.parts) + size(d.row_offsets);
}

// ---------------------------------------------------------------------------------- basis and
// fields

namespace {

/// What a triangle covers of one row of cells, as pieces, whole cells among them.
template <class Visit>
void for_each_piece_in_row(const std::array<TexelPoint, 3>& corners, int row, const Visit& visit) {
  clip_row(
      corners, row,
      [&](const Piece& piece) {
        if (piece.area() >= smallest_piece) visit(piece);
      },
      [&](int, int first, int last) {
        for (int column = first; column <= last; ++column) visit(whole_cell(row, column));
      });
}

void add_rule(int triangle, const std::array<double, 2>& a, const std::array<double, 2>& b,
              const std::array<double, 2>& c, SeamCell& cell) {
  const double area = std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
  for (const TrianglePoint& p : triangle_rule_4())
    cell.add_point(triangle, p.l0 * a[0] + p.l1 * b[0] + p.l2 * c[0],
                   p.l0 * a[1] + p.l1 * b[1] + p.l2 * c[1], p.weight * area);
}

}  // namespace

void TexelSpace::for_each_piece(const std::function<void(const TexelSamples&)>& visit) const {
  const Data& d = *data_;
  SeamCell cell(d.atlas, *d.seams, d.grid);
  std::vector<SeamCell::Polygon> bilinear;
  BasisSamples points;
  std::vector<int> unknowns;
  TexelSamples samples;
  const auto visit_cell = [&] {
    cell.evaluate(points);
    samples.values = points.values;
    samples.dx = points.dx;
    samples.dy = points.dy;
    samples.weights = Eigen::Map<const Vector>(points.weights.data(), std::ssize(points.weights));
    unknowns.clear();
    for (int texel : points.texels) unknowns.push_back(d.unknown[texel]);
    samples.texels = unknowns;
    visit(samples);
  };
  for (int t = 0; t < d.triangles(); ++t) {
    if (d.atlas.chart[t] < 0) continue;
    const int texture = d.surface.mesh.texture(t);
    samples.triangle = t;
    const auto [first, end] = rows_of(d.atlas.corners[t]);
    for (int row = first; row < end; ++row) {
      const auto near = d.near_row(t, row);
      for_each_piece_in_row(d.atlas.corners[t], row, [&](const Piece& piece) {
        cell.start(texture, piece.column, row, NearSeams::cell(near, piece.column));
        bilinear.clear();
        cell.add_piece(t, piece, bilinear);
        if (!cell.empty()) visit_cell();
        if (bilinear.empty()) return;
        cell.start(texture, piece.column, row, {});
        for (const SeamCell::Polygon& polygon : bilinear)
          for (std::size_t k = 2; k < polygon.size(); ++k)
            add_rule(t, polygon[0], polygon[k - 1], polygon[k], cell);
        visit_cell();
      });
    }
  }
}

std::vector<TexelWeight> TexelSpace::basis_at(int triangle, const Vector3& barycentric) const {
  const Data& d = *data_;
  require(triangle >= 0 && triangle < d.triangles() && d.atlas.chart[triangle] >= 0,
          "a triangle with a chart is needed");
  const auto& corners = d.atlas.corners[triangle];
  // Relative to the first corner's cell, to keep the fraction's bits.
  const int column0 = floor_texel(corners[0].x), row0 = floor_texel(corners[0].y);
  double x = 0, y = 0;
  for (int k = 0; k < 3; ++k) {
    x +=
        barycentric[k] * double(corners[k].x - column0 * TexelPoint::one) / double(TexelPoint::one);
    y += barycentric[k] * double(corners[k].y - row0 * TexelPoint::one) / double(TexelPoint::one);
  }
  const int column = column0 + int(std::floor(x)), row = row0 + int(std::floor(y));
  SeamCell cell(d.atlas, *d.seams, d.grid);
  cell.start(d.surface.mesh.texture(triangle), column, row,
             NearSeams::cell(d.near_row(triangle, row), column));
  cell.add_point(triangle, x - std::floor(x), y - std::floor(y), 0);
  BasisSamples samples;
  cell.evaluate(samples);
  std::vector<TexelWeight> result;
  for (std::size_t k = 0; k < samples.texels.size(); ++k)
    if (samples.values(0, k) != 0 && d.unknown[samples.texels[k]] >= 0)
      result.push_back({d.unknown[samples.texels[k]], samples.values(0, k)});
  return result;
}

Signal TexelSpace::divergence(const std::vector<std::vector<Vector3>>& fields) const {
  const Data& d = *data_;
  for (const auto& field : fields)
    require(int(field.size()) == d.triangles(), "one vector per triangle is needed");
  Signal result = Signal::Zero(size(), Eigen::Index(fields.size()));
  for_each_piece([&](const TexelSamples& samples) {
    // X in texel coordinates: least squares of e ξ = X over the triangle's two edge vectors.
    const int t = samples.triangle;
    const auto& p = d.atlas.corners[t];
    Eigen::Matrix2d E;
    E << p[1].column() - p[0].column(), p[2].column() - p[0].column(), p[1].row() - p[0].row(),
        p[2].row() - p[0].row();
    Eigen::Matrix<double, 3, 2> e;
    e.col(0) = d.surface.mesh.position(t, 1) - d.surface.mesh.position(t, 0);
    e.col(1) = d.surface.mesh.position(t, 2) - d.surface.mesh.position(t, 0);
    const Eigen::Matrix2d gram = e.transpose() * e;
    const Eigen::RowVectorXd sum_x = samples.weights.transpose() * samples.dx;
    const Eigen::RowVectorXd sum_y = samples.weights.transpose() * samples.dy;
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const Eigen::Vector2d xi = E * gram.ldlt().solve(e.transpose() * fields[f][t]);
      for (std::size_t k = 0; k < samples.texels.size(); ++k)
        result(samples.texels[k], f) +=
            d.metrics[t].density * (xi.x() * sum_x[k] + xi.y() * sum_y[k]);
    }
  });
  return result;
}

std::vector<std::array<int, 2>> TexelSpace::edges() const {
  const SparseMatrix pattern = system(0, 1);
  std::vector<std::array<int, 2>> result;
  result.reserve(pattern.nonZeros() / 2);
  for (int i = 0; i < pattern.rows(); ++i)
    for (SparseMatrix::InnerIterator it(pattern, i); it; ++it)
      if (it.col() > i) result.push_back({i, int(it.col())});
  return result;
}

Signal TexelSpace::edge_divergence(const std::vector<std::array<int, 2>>& edges,
                                   const Signal& z) const {
  require(z.rows() == std::ssize(edges), "one row per edge is needed");
  const Data& d = *data_;
  const Eigen::Index channels = z.cols();
  Signal result = Signal::Zero(size(), channels);
  Eigen::MatrixXd difference;
  for_each_piece([&](const TexelSamples& samples) {
    const int count = int(samples.texels.size());
    const TexelMetric& metric = d.metrics[samples.triangle];
    for (Eigen::Index c = 0; c < channels; ++c) {
      difference.setZero(count, count);
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
          const std::array<int, 2> pair{samples.texels[i], samples.texels[j]};
          if (pair[0] >= pair[1]) continue;
          const auto at = std::lower_bound(edges.begin(), edges.end(), pair);
          if (at == edges.end() || *at != pair) continue;
          difference(i, j) = z(at - edges.begin(), c);
          difference(j, i) = -difference(i, j);
        }
      // ω = Σ_j (Σ_i φ_i z_ij) ∇φ_j, over both orders of each pair
      const Eigen::MatrixXd mixed = samples.values * difference;
      const Eigen::VectorXd wx = (mixed.array() * samples.dx.array()).rowwise().sum();
      const Eigen::VectorXd wy = (mixed.array() * samples.dy.array()).rowwise().sum();
      const Eigen::VectorXd fx = samples.weights.array() * (metric.a * wx + metric.b * wy).array();
      const Eigen::VectorXd fy = samples.weights.array() * (metric.b * wx + metric.c * wy).array();
      const Eigen::VectorXd b = samples.dx.transpose() * fx + samples.dy.transpose() * fy;
      for (int k = 0; k < count; ++k) result(samples.texels[k], c) += b[k];
    }
  });
  return result;
}

}  // namespace mq
