// Finds the unknowns of a texel space, where they lie and what couples them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/atlas/texel_patches.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/parallel.h"
#include "mq/base/release.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

namespace {

/// What texels and cells take at least, before anything is solved.
constexpr double bytes_per_texel = 100;

}  // namespace

void TexelSpace::Data::integrate(const TexelSpaceOptions& options, const Progress& progress) {
  marked = options.cells;
  const double count = marked.empty() ? atlas.texel_area : double(std::ranges::count(marked, 1));
  require_memory(std::int64_t(bytes_per_texel * count), fmt::format("the space of {:.3g} million texels", 1e-6 * count),
                 "take smaller pictures, or a machine with more");
  metrics = options.metrics;
  if (metrics.empty()) {
    metrics.resize(triangles());
    for (int t = 0; t < triangles(); ++t)
      if (atlas.chart[t] >= 0) metrics[t] = texel_metric(surface, atlas, t);
  } else {
    require_metrics();
  }
  seams = std::make_unique<Seams>(surface, atlas);
  near = std::make_unique<NearSeams>(atlas, *seams);
  progress.step("find seams", 0.1).at(1);
  const bool soft = options.seams == TexelSpaceOptions::Seams::soft;
  require(marked.empty() || std::ssize(marked) == grid.cell_count(), "one mark per cell is needed");
  if (soft) near.reset();
  cells = cells_with_integrals(progress.step("cut and integrate", 0.6));
  if (soft) add_soft_seams(options.seam_penalty);
}

TexelCells TexelSpace::Data::cells_with_integrals(const Progress& progress) const {
  return integrate_cells(surface, atlas, metrics, grid, seams.get(), near.get(), marked, progress);
}

void TexelSpace::Data::require_integrals() const {
  require(integrated, "the integrals of this space were let go of; integrate again");
}

void TexelSpace::Data::require_places() const {
  require(packed_places.empty(), "the texels of this space were let go of; place them again");
}

void TexelSpace::let_go_of_integrals() const {
  Data& d = *data_;
  if (!d.near) return;
  d.integrated = false;
  d.cells = {};
  release(d.unknown);
  release(d.block_offsets);
  release(d.parts);
}

void TexelSpace::let_go_of_texels() const {
  Data& d = *data_;
  let_go_of_integrals();
  if (d.integrated || !d.packed_places.empty()) return;
  std::vector<Texels::Place>& places = d.texels.places;
  for (int i = 0; i < int(places.size()); ++i) {
    const auto side_by_side = [](const Texels::Place& a, const Texels::Place& b) {
      return a.texture == b.texture && a.y == b.y && a.x + 1 == b.x;
    };
    if (i == 0 || !side_by_side(places[i - 1], places[i])) d.packed_places.push_back({places[i], i});
  }
  d.packed_places.push_back({{}, int(places.size())});
  release(places);
  release(d.texels.positions);
  release(d.texels.chart);
  release(d.texels.interior);
}

void TexelSpace::place_again() const {
  Data& d = *data_;
  if (d.packed_places.empty()) return;
  d.texels.places.resize(std::size_t(d.packed_places.back().unknown));
  parallel_for(std::ssize(d.packed_places) - 1, [&](std::int64_t r) {
    const Data::RowPiece &row = d.packed_places[r], &next = d.packed_places[r + 1];
    for (int i = row.unknown; i < next.unknown; ++i)
      d.texels.places[i] = {row.first.texture, row.first.x + i - row.unknown, row.first.y};
  });
  release(d.packed_places);
}

void TexelSpace::integrate_again() const {
  Data& d = *data_;
  if (d.integrated) return;
  d.cells = d.cells_with_integrals({});
  d.number_texels();
  d.find_parts();
  d.place_texels();
  release(d.shared);
  release(d.packed_places);
  d.integrated = true;
}

/// Given metrics: pieces next to seams are summed as squares, which takes the determinant for 1.
void TexelSpace::Data::require_metrics() const {
  require(int(metrics.size()) == triangles(), "one metric per triangle is needed");
  for (int t = 0; t < triangles(); ++t) {
    const TexelMetric& m = metrics[t];
    if (atlas.chart[t] < 0 || (m.density > 0 && std::isfinite(m.density) && m.a > 0 &&
                               std::abs(m.a * m.c - m.b * m.b - 1) <= 1e-6 * (m.a * m.c + 1)))
      continue;
    throw InvalidInput(
        fmt::format("the metric of triangle {} has density {} and √|g| g⁻¹ = ({}, {}; {}, {}): "
                    "the density must be positive, the tensor too, with determinant 1",
                    t, m.density, m.a, m.b, m.b, m.c));
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
        (mesh.position(h / 3, next(h) % 3) - mesh.position(h / 3, h % 3)).norm();
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

namespace {

/// The surface's affine map of one triangle, continued to a place in its chart at most a texel or
/// so away; where the triangle itself is smaller than a texel, to its nearest corner instead.
class PlacedTriangle {
 public:
  PlacedTriangle(const Surface& surface, const Atlas& atlas, int triangle)
      : triangle_(triangle), origin_(surface.mesh.position(triangle, 0)),
        u_(surface.mesh.position(triangle, 1) - origin_), v_(surface.mesh.position(triangle, 2) - origin_) {
    const auto& p = atlas.corners[triangle];
    x0_ = p[0].column(), y0_ = p[0].row();
    ux_ = p[1].column() - x0_, uy_ = p[1].row() - y0_;
    vx_ = p[2].column() - x0_, vy_ = p[2].row() - y0_;
    det_ = ux_ * vy_ - uy_ * vx_;
  }

  int triangle() const { return triangle_; }

  Vector3 position_near(double x, double y) const {
    double l1 = ((x - x0_) * vy_ - (y - y0_) * vx_) / det_;
    double l2 = (ux_ * (y - y0_) - uy_ * (x - x0_)) / det_;
    constexpr double reach = 2;
    const double outside = std::max({-l1, -l2, l1 + l2 - 1});
    if (!(outside < reach)) l1 = std::clamp(l1, 0.0, 1.0), l2 = std::clamp(l2, 0.0, 1.0 - l1);
    return origin_ + l1 * u_ + l2 * v_;
  }

 private:
  int triangle_;
  Vector3 origin_, u_, v_;
  double x0_, y0_, ux_, uy_, vx_, vy_, det_;
};

/// See `Texels::origin`: from ten lengths of the model on.
Vector3 origin_for(const Surface& surface) {
  if (surface.mesh.triangles.empty()) return Vector3::Zero();
  const Vector3 corner = surface.mesh.position(0, 0);
  return corner.norm() > 10 * std::sqrt(surface.area) ? corner : Vector3(Vector3::Zero());
}

}  // namespace

void TexelSpace::Data::place_texels() {
  const int n = int(texels.places.size());
  texels.origin = origin_for(surface);
  texels.positions.assign(n, {0, 0, 0});
  texels.chart.assign(n, -1);
  texels.interior.assign(n, 0);
  shared.assign(n, 0);
  parallel_blocks(n, 1024, [&](std::int64_t begin, std::int64_t end) {
    std::optional<PlacedTriangle> placed;  // texels side by side are often of one triangle
    for (std::int64_t i = begin; i < end; ++i) {
      const int best = find_chart(int(i));
      if (best < 0) continue;
      if (!placed || placed->triangle() != best) placed.emplace(surface, atlas, best);
      // The triangle's chart may lie whole textures away where the texture repeats.
      const Texels::Place& at = texels.places[i];
      const TextureSize& size = atlas.textures[at.texture];
      double x = at.x, y = at.y;
      if (size.wrap == Wrap::repeat) {
        const TexelPoint& p = atlas.corners[best][0];
        x += std::round((p.column() - x) / size.width) * size.width;
        y += std::round((p.row() - y) / size.height) * size.height;
      }
      const Vector3 place = placed->position_near(x, y) - texels.origin;
      texels.positions[i] = {float(place.x()), float(place.y()), float(place.z())};
    }
  });
}

/// Finds the chart of texel i, whether it is the interior of that and whether others share it. Returns the triangle
/// that says best where it lies, −1: none.
int TexelSpace::Data::find_chart(int i) {
  const Texels::Place& at = texels.places[i];
  const auto turn = [&](int chart) { return atlas.charts[chart].turn; };
  int best = -1;
  float area = -1;
  bool whole = is_grid_row(i);
  for_each_cell(at, [&](const Incidence& c) {
    const int kind = cells.kind[c.cell];
    if (kind < 0) {
      whole = false;
      return;
    }
    if (kind == best && area == 1) return;  // one triangle covers both, and says nothing more
    const TexelCells::CutInfo info = cut_info(kind);
    if (std::abs(info.coverage - 1) > 1e-5f) whole = false;
    const int chart = info.triangle < 0 ? -1 : atlas.chart[info.triangle];
    if (info.several || (texels.chart[i] >= 0 && chart >= 0 && chart != texels.chart[i]))
      shared[i] = 1;
    if (chart >= 0 && (texels.chart[i] < 0 || turn(chart) < turn(texels.chart[i])))
      texels.chart[i] = chart;
    if (tells_more(atlas, info.largest, info.triangle, area, best))
      area = info.largest, best = info.triangle;
  });
  texels.interior[i] = best >= 0 && whole && !shared[i];
  return best;
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

/// Of the surface, per texel² of the pieces in the cells around an unknown.
double TexelSpace::Data::texel_area(int i) const {
  double area = 0, coverage = 0;
  for_each_cell(texels.places[i], [&](const Incidence& at) {
    const int kind = cells.kind[at.cell];
    if (kind < 0) return;
    const TexelCells::CutInfo info = cut_info(kind);
    area += info.surface;
    coverage += info.coverage;
  });
  return coverage > 0 ? area / coverage : atlas.surface_area / atlas.texel_area;
}

/// M_ii.
double TexelSpace::Data::mass_at_texel(int i) const {
  double mass = 0;
  for_each_cell(texels.places[i], [&](const Incidence& at) {
    if (!active(at.cell)) return;
    const CellIntegrals& cell = integrals(at.cell);
    for (int d = 0; d < 4; ++d)  // the texel is at several of them at the border of a picture
      if (unknown[at.corners[d]] == i) mass += cell.mass[mass_at[at.corner][d]];
  });
  for (const Part& part : blocks_of(i)) {
    const SeamBlocks::Block& block = cells.seams.blocks[part.block];
    mass += cells.seams.mass[block.first_value + SeamBlocks::index(part.index, part.index, block.count)];
  }
  return mass;
}

void TexelSpace::Data::find_weak() {
  constexpr double hardly_seen = 1e-3;
  std::vector<double> area_of_weak(texels.size(), 0);  // else 0
  parallel_for(texels.size(), [&](std::int64_t i) {
    if (texels.interior[i]) return;
    const double diagonal = mass_at_texel(int(i));
    const double area = texel_area(int(i));
    if (diagonal < hardly_seen * area) area_of_weak[i] = area;
  });
  for (int i = 0; i < texels.size(); ++i)
    if (area_of_weak[i] > 0) weak.push_back({i, area_of_weak[i]});
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
  release(shared);
  const auto add = [&](const char* kind, std::vector<std::int64_t> all, const char* message, const char* brief) {
    add_defect(defects, kind, Defect::Severity::warning, "texel", all, message, brief);
    if (!all.empty()) list_places(grid, std::move(all), defects.back());
  };
  add("overlapping_triangles", std::move(overlapping),
      "texels between which triangles lie on each other: the places of the surface there share one colour; unwrap "
      "them apart to treat them apart",
      "between which triangles lie on each other: one colour for all");
  add("shared_texels", std::move(several),
      "texels that several charts read: charts nearer than a texel's footprint share it, so values leak between "
      "them; a wider gutter or a larger texture parts them",
      "read by several charts: values leak between them");
}

}  // namespace mq
