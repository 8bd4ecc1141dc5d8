#include "mq/trace/trace_atlas.h"

#include <algorithm>
#include <cmath>

#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/trace/atlas_walk.h"
#include "mq/trace/detail/atlas_borders.h"

namespace mq {
namespace {

int modulo(int i, int n) { return i >= 0 ? i % n : n - 1 - (-1 - i) % n; }

/// Weights of a cell's corners: upper left, upper right, lower left, lower right.
}  // namespace

TraceAtlas::TraceAtlas(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                       const Progress& progress)
    : surface_(&surface), atlas_(&atlas), space_(&space) {
  number_nodes(atlas);
  progress.at(0.3);
  metrics_ = by_cell(space.cell_metrics());
  flags_.resize(unknowns_.size());
  for (const Texture& texture : textures_) {
    parallel_for(
        texture.height + 1,
        [&](std::int64_t j) {
          for (int i = 0; i <= texture.width; ++i) {
            flags_[std::size_t(texture.first) + std::size_t(j) * texture.stride + i] = (i + int(j)) & 1;
          }
        },
        64);
    mark_ends(texture);
  }
  progress.at(0.7);
  borders_ = std::make_unique<AtlasBorders>(surface, atlas, *this);
  mark_borders();
  progress.at(1);
}

TraceAtlas::~TraceAtlas() = default;
TraceAtlas::TraceAtlas(TraceAtlas&&) noexcept = default;

void TraceAtlas::number_nodes(const Atlas& atlas) {
  std::int64_t first = 0;
  for (const TextureSize& size : atlas.textures) {
    textures_.push_back(
        {int(first), size.width, size.height, size.width + 2, size.wrap == Wrap::repeat});
    first += std::int64_t(size.width + 2) * (size.height + 2);
    require(first < std::int64_t(1) << 30,
            "the textures have more than 2^30 texels together: paths are not followed on so many");
  }
  unknowns_.assign(std::size_t(first), -1);
  const auto& places = space_->texels().places;
  for (int i = 0; i < space_->size(); ++i) {
    const auto& at = places[std::size_t(i)];
    const Texture& texture = textures_[std::size_t(at.texture)];
    unknowns_[std::size_t(texture.first + (at.y + 1) * texture.stride + at.x + 1)] = i;
  }
  // Beside the texture: what a lookup finds there.
  for (const Texture& t : textures_) {
    const auto node = [&](int i, int j) -> int& {
      return unknowns_[std::size_t(t.first + (j + 1) * t.stride + i + 1)];
    };
    for (int j = 0; j < t.height; ++j) {
      node(-1, j) = node(t.repeats ? t.width - 1 : 0, j);
      node(t.width, j) = node(t.repeats ? 0 : t.width - 1, j);
    }
    for (int i = -1; i <= t.width; ++i) {
      node(i, -1) = node(i, t.repeats ? t.height - 1 : 0);
      node(i, t.height) = node(i, t.repeats ? 0 : t.height - 1);
    }
  }
}

/// Cells beside which the texture ends or begins anew.
void TraceAtlas::mark_ends(const Texture& t) {
  const int low = t.repeats ? 1 : 0;  // of repeating textures cell −1 is the last one
  const auto mark = [&](int i, int j, unsigned char flag) {
    flags_[std::size_t(t.first + j * t.stride + i)] |= flag;
  };
  for (int j = low; j <= t.height; ++j) {
    mark(low, j, left_flag);
    mark(t.width, j, right_flag);
  }
  for (int i = low; i <= t.width; ++i) {
    mark(i, low, top_flag);
    mark(i, t.height, bottom_flag);
  }
}

/// The cells in which charts end, and those next to one with a seam.
void TraceAtlas::mark_borders() {
  for (const int cell : borders_->cells()) {
    flags_[std::size_t(cell)] |= border_flag;
    const auto is_seam = [&](const BorderSegment& b) { return borders_->across(b.half_edge) >= 0; };
    if (!std::ranges::any_of(borders_->of(cell), is_seam)) continue;
    for (const int row : {cell, beyond(cell, Side::top), beyond(cell, Side::bottom)})
      if (row >= 0)
        for (const int c : {row, beyond(row, Side::left), beyond(row, Side::right)})
          if (c >= 0) flags_[std::size_t(c)] |= seam_flag;
  }
}

int TraceAtlas::find_texture(int cell) const {
  const auto after = std::upper_bound(textures_.begin(), textures_.end(), cell,
                                      [](int c, const Texture& t) { return c < t.first; });
  return int(after - textures_.begin()) - 1;
}

int TraceAtlas::beyond_end(int cell, Side side) const {
  const Texture& t = textures_[std::size_t(texture_of(cell))];
  if (!t.repeats) return -1;
  switch (side) {
    case Side::left: return cell + t.width - 1;
    case Side::right: return cell - t.width + 1;
    case Side::top: return cell + (t.height - 1) * t.stride;
    case Side::bottom: return cell - (t.height - 1) * t.stride;
  }
  return -1;
}

int TraceAtlas::cell(int texture, int column, int row) const {
  const Texture& t = textures_[std::size_t(texture)];
  if (t.repeats) {
    column = modulo(column, t.width);
    row = modulo(row, t.height);
  } else if (column < -1 || row < -1 || column >= t.width || row >= t.height) {
    return -1;
  }
  return t.first + (row + 1) * t.stride + column + 1;
}

ChartPlace TraceAtlas::place(int chart, int texture, const Vector2& texel) const {
  const Texture& t = textures_[std::size_t(texture)];
  Vector2 p = texel;
  if (!t.repeats)  // beyond half a texel from its border a texture is constant
    p = p.cwiseMax(Vector2(-1, -1)).cwiseMin(Vector2(t.width, t.height));
  int column = int(std::floor(p.x())), row = int(std::floor(p.y()));
  if (!t.repeats) {
    column = std::min(column, t.width - 1);
    row = std::min(row, t.height - 1);
  }
  return {chart, cell(texture, column, row), p.x() - column, p.y() - row};
}

/// Of a texel that no triangle covers: its border nearest to it, and on over that.
ChartPlace TraceAtlas::start(int i, int triangle) const {
  const Texels& texels = space_->texels();
  const Texels::Place& at = texels.places[std::size_t(i)];
  const int chart_there = triangle < 0 ? texels.chart[std::size_t(i)] : atlas_->chart[std::size_t(triangle)];
  const ChartPlace own = place(chart_there, at.texture, Vector2(at.x, at.y));
  if (triangle >= 0) return own;
  const BorderSegment* nearest = nullptr;
  double least = INFINITY, part = 0;
  Vector2 way = Vector2::Zero();
  for (const int dy : {-1, 0})
    for (const int dx : {-1, 0}) {
      const int around = cell(at.texture, at.x + dx, at.y + dy);
      if (around < 0) continue;
      for (const BorderSegment& border : borders_->of(around)) {
        if (border.chart != own.chart) continue;
        const Vector2 to = Vector2(-dx, -dy) - border.from;
        const double s = std::clamp(to.dot(border.edge) / border.edge.squaredNorm(), 0.0, 1.0);
        const Vector2 rest = to - s * border.edge;
        if (!(rest.norm() < least)) continue;
        least = rest.norm();
        nearest = &border;
        part = s;
        way = rest;
      }
    }
  if (!nearest) return own;
  const HalfEdge h = nearest->half_edge;
  const Vector2 border = borders_->at(h, part);
  if (const auto beyond = AtlasWalk(*surface_, *atlas_)({h / 3, border}, way)) {
    const int chart = atlas_->chart[std::size_t(beyond->triangle)];
    return place(chart, atlas_->charts[std::size_t(chart)].texture, beyond->texel);
  }
  return place(own.chart, at.texture, border);
}

TraceAtlas::Starts TraceAtlas::starts() const {
  const std::vector<Coverage> coverage = texel_coverage(*surface_, *atlas_);
  Starts starts;
  starts.places.resize(std::size_t(space_->size()));
  starts.outside.resize(std::size_t(space_->size()));
  parallel_for(space_->size(), [&](std::int64_t i) {
    const Texels::Place& at = space_->texels().places[std::size_t(i)];
    const int triangle = coverage[std::size_t(at.texture)].triangle(at.x, at.y);
    starts.places[std::size_t(i)] = start(int(i), triangle);
    starts.outside[std::size_t(i)] = triangle < 0;
  });
  return starts;
}

/// visit(unknown, weight), weights of sum 1 where any is known.
template <class Visit>
void TraceAtlas::for_each_weight(const ChartPlace& at, const Visit& visit) const {
  if (flags_[std::size_t(at.cell)] & seam_flag && at.chart >= 0) {
    const Texture& t = textures_[std::size_t(texture_of(at.cell))];
    const int local = at.cell - t.first;
    for (const BasisWeight& w :
         space_->basis_in(at.chart, local % t.stride - 1, local / t.stride - 1, at.x, at.y))
      visit(w.unknown, w.weight);
    return;
  }
  for_each_corner(at, visit);
}

void TraceAtlas::for_each_read(const ChartPlace& at, const std::function<void(int, double)>& visit) const {
  for_each_weight(at, visit);
}

Vector2 TraceAtlas::texel(const ChartPlace& at) const {
  const Texture& t = textures_[std::size_t(texture_of(at.cell))];
  const int local = at.cell - t.first;
  return Vector2(local % t.stride - 1 + at.x, local / t.stride - 1 + at.y);
}

void TraceAtlas::for_each_seam(const std::function<void(double, const SeamPlaces&)>& visit) const {
  for (HalfEdge h = 0; h < 3 * surface_->triangle_count(); ++h) {
    if (!borders_->is_border(h)) continue;
    const HalfEdge twin = borders_->across(h);
    if (twin < h) continue;
    const auto there = [&](HalfEdge e, double s) {
      return place(borders_->chart(e), borders_->texture(e), borders_->at(e, s));
    };
    visit(std::max(borders_->edge(h).norm(), borders_->edge(twin).norm()),
          [&](double s) { return std::pair(there(h, s), there(twin, 1 - s)); });
  }
}

void TraceAtlas::value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const {
  constexpr Eigen::Index most = 16;  // channels at once
  for (Eigen::Index first = 0; first < signal.cols(); first += most) {
    const Eigen::Index count = std::min(most, signal.cols() - first);
    std::array<double, most> sum{}, low, high;
    low.fill(INFINITY), high.fill(-INFINITY);
    for_each_weight(at, [&](int i, double weight) {
      for (Eigen::Index c = 0; c < count; ++c) {
        const double here = signal(i, first + c);
        sum[std::size_t(c)] += weight * here;
        low[std::size_t(c)] = std::min(low[std::size_t(c)], here);
        high[std::size_t(c)] = std::max(high[std::size_t(c)], here);
      }
    });
    for (std::size_t c = 0; c < std::size_t(count); ++c)
      if (low[c] <= high[c]) row(0, first + Eigen::Index(c)) = std::clamp(sum[c], low[c], high[c]);
  }
}

namespace {

/// Weights of the values at −1, 0, 1, 2 for the one at x from 0 to 1.
std::array<double, 4> catmull_rom(double x) {
  return {0.5 * x * (x * (2 - x) - 1), 0.5 * (x * x * (3 * x - 5) + 2), 0.5 * x * (x * (4 - 3 * x) + 1),
          0.5 * x * x * (x - 1)};
}

}  // namespace

void TraceAtlas::plain_value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const {
  row.setZero();
  for_each_corner(at, [&](int i, double weight) { row.row(0) += weight * signal.row(i); });
}

void TraceAtlas::sharp_value(const Signal& signal, const ChartPlace& at, Eigen::Ref<Signal> row) const {
  const int step = stride(at.cell);
  constexpr unsigned char ends = left_flag | top_flag | right_flag | bottom_flag;
  bool inside = !(flags_[std::size_t(at.cell)] & ends);
  for (int j = -1; j <= 1 && inside; ++j)
    for (int i = -1; i <= 1 && inside; ++i)
      inside = !bordered(at.cell + i + j * step) && covered(at.cell + i + j * step);
  if (!inside) return value(signal, at, row);
  const std::array<double, 4> along = catmull_rom(at.x), down = catmull_rom(at.y);
  for (Eigen::Index c = 0; c < signal.cols(); ++c) {
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const double here = signal(unknown(at.cell + i - 1 + (j - 1) * step), c);
        sum += along[std::size_t(i)] * down[std::size_t(j)] * here;
        low = std::min(low, here);
        high = std::max(high, here);
      }
    row(0, c) = std::clamp(sum, low, high);
  }
}

Vector3 TraceAtlas::position(const ChartPlace& at) const {
  Vector3 sum = Vector3::Zero();
  for_each_weight(at, [&](int i, double weight) { sum += weight * space_->texels().position(i); });
  return sum;
}

}  // namespace mq
