#include "mq/trace/detail/atlas_borders.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mq {
namespace {

/// A segment is entered in the cells it touches, and in those it misses by rounding.
constexpr double rim = 1e-9;  // texels

/// visit(column, row) for the cells that a segment in texels runs through, by rows.
template <class Visit>
void for_cells_along(const Vector2& from, const Vector2& edge, const Visit& visit) {
  const Vector2 to = from + edge;
  const auto [top, bottom] = std::minmax(from.y(), to.y());
  for (int row = int(std::floor(top - rim)); row <= int(std::floor(bottom + rim)); ++row) {
    // Between which parts of the segment the row lies.
    double begin = 0, end = 1;
    if (edge.y() != 0) {
      const auto part = [&](double y) { return std::clamp((y - from.y()) / edge.y(), 0.0, 1.0); };
      std::tie(begin, end) = std::minmax({part(row - rim), part(row + 1 + rim)});
    }
    const double x = from.x() + begin * edge.x(), other = from.x() + end * edge.x();
    const auto [left, right] = std::minmax(x, other);
    for (int column = int(std::floor(left - rim)); column <= int(std::floor(right + rim)); ++column)
      visit(column, row);
  }
}

}  // namespace

AtlasBorders::AtlasBorders(const Surface& surface, const Atlas& atlas, const TraceAtlas& domain)
    : surface_(surface), atlas_(atlas) {
  std::vector<std::pair<int, int>> order;  // cell, segment
  std::vector<BorderSegment> found;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    if (!is_border(h)) continue;
    const Vector2 from = source(h), way = edge(h);
    for_cells_along(from, way, [&](int column, int row) {
      const int cell = domain.cell(texture(h), column, row);
      if (cell < 0) return;
      order.push_back({cell, int(found.size())});
      found.push_back({h, chart(h), from - Vector2(column, row), way, turn(h)});
    });
  }
  std::sort(order.begin(), order.end());
  segments_.reserve(found.size());
  for (const auto& [cell, segment] : order) {
    if (cells_.empty() || cells_.back() != cell) {
      cells_.push_back(cell);
      offsets_.push_back(int(segments_.size()));
    }
    segments_.push_back(found[std::size_t(segment)]);
  }
  offsets_.push_back(int(segments_.size()));
}

HalfEdge AtlasBorders::across(HalfEdge h) const {
  const HalfEdge twin = surface_.twins[std::size_t(h)];
  return atlas_.edges[std::size_t(h)] == EdgeKind::seam && twin >= 0 && chart(twin) >= 0 ? twin : -1;
}

std::span<const BorderSegment> AtlasBorders::of(int cell) const {
  const auto at = std::lower_bound(cells_.begin(), cells_.end(), cell);
  if (at == cells_.end() || *at != cell) return {};
  const std::size_t k = std::size_t(at - cells_.begin());
  return {segments_.data() + offsets_[k], std::size_t(offsets_[k + 1] - offsets_[k])};
}

Vector2 AtlasBorders::source(HalfEdge h) const {
  const TexelPoint& p = atlas_.corners[std::size_t(h / 3)][std::size_t(h % 3)];
  return {p.column(), p.row()};
}

double AtlasBorders::turn(HalfEdge h) const {
  const auto& c = atlas_.corners[std::size_t(h / 3)];
  return orientation(c[0], c[1], c[2]) < 0 ? -1 : 1;
}

double AtlasBorders::length(HalfEdge h) const {
  const Mesh& mesh = surface_.mesh;
  return (mesh.position(h / 3, (h % 3 + 1) % 3) - mesh.position(h / 3, h % 3)).norm();
}

}  // namespace mq
