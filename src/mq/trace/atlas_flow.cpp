/// In a triangle with its right angle at corner 0 and sides of a texel along d₁ and d₂, weights change by the parts of X
/// along these. For X = −∇P with G = g⁻¹ the mean metric of the cell that is −(G₁₁ p₁ + G₁₂ p₂) and −(G₁₂ p₁ + G₂₂ p₂),
/// p_k = P_k − P₀.

#include "mq/trace/atlas_flow.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/trace/detail/atlas_path.h"

namespace mq {
namespace {

using walk::after;
using walk::before;
using Side = TraceAtlas::Side;

/// Paths of one piece of work.
constexpr std::int64_t atlas_block = 1024;

/// A triangle in a cell of either diagonal: its corners as steps from the upper left node, all turning the same way, and
/// the sides of the cell opposite corners 1 and 2.
struct Shape {
  int corners[3][2];
  Side opposite_1, opposite_2;
};
constexpr Shape shapes[2][2] = {
    {{{{1, 0}, {1, 1}, {0, 0}}, Side::top, Side::right}, {{{0, 1}, {0, 0}, {1, 1}}, Side::bottom, Side::left}},
    {{{{0, 0}, {1, 0}, {0, 1}}, Side::left, Side::top}, {{{1, 1}, {0, 1}, {1, 0}}, Side::right, Side::bottom}}};

/// 2·s + (k − 1): of a cell of either diagonal the triangle that has a side, and the corner opposite.
int triangle_at(int diagonal, Side side) {
  for (int s = 0; s < 2; ++s) {
    if (shapes[diagonal][s].opposite_1 == side) return 2 * s;
    if (shapes[diagonal][s].opposite_2 == side) return 2 * s + 1;
  }
  return 0;
}

Side opposite(Side side) {
  switch (side) {
    case Side::left: return Side::right;
    case Side::right: return Side::left;
    case Side::top: return Side::bottom;
    case Side::bottom: return Side::top;
  }
  return side;
}

}  // namespace

AtlasFlow AtlasFlow::downhill(const TraceAtlas& domain, const Vector& potential) {
  require(potential.size() == domain.space().size() && potential.allFinite(),
          fmt::format("a potential needs a finite value at each of {} texels; {} were given",
                      domain.space().size(), potential.size()));
  AtlasFlow flow(domain);
  flow.potential_.resize(std::size_t(domain.node_count()));
  parallel_for(domain.node_count(), [&](std::int64_t node) {
    const int i = domain.unknown(int(node));
    flow.potential_[std::size_t(node)] = i < 0 ? 0 : potential[i];
  });
  return flow;
}

AtlasFlow AtlasFlow::along(const TraceAtlas& domain, const std::vector<std::array<double, 2>>& field) {
  require(std::ssize(field) == domain.grid_cell_count(), "a field needs two values for each cell");
  AtlasFlow flow(domain);
  flow.field_ = domain.by_cell(field);
  for (int cell = 0; cell < domain.node_count(); ++cell) {
    const auto& [x, y] = flow.field_[std::size_t(cell)];
    require(!domain.covered(cell) || (std::isfinite(x) && std::isfinite(y)),
            "a field needs finite values in each cell that a chart covers");
  }
  return flow;
}

std::array<double, 3> AtlasFlow::rates(int t) const {
  const int cell = t >> 1, s = t & 1, diagonal = domain_->diagonal(cell);
  if (potential_.empty()) {
    if (!domain_->covered(cell)) return {};
    const std::array<double, 2>& X = field_[std::size_t(cell)];
    const double sign = s ? -1 : 1;  // of the step from corner 0 to the right (diagonal 1) or left (0)
    const double first = diagonal ? sign * X[0] : sign * X[1], second = diagonal ? sign * X[1] : -sign * X[0];
    return {-(first + second), first, second};
  }
  const int stride = domain_->stride(cell);
  const double* P = potential_.data() + cell;
  const TexelSpace::CellMetric& G = domain_->metric(cell);
  double p1, p2, g11, g12, g22;
  if (diagonal) {  // corner 0 upper left (s = 0) or lower right
    const double P0 = s ? P[stride + 1] : P[0], right = s ? P[stride] : P[1], down = s ? P[1] : P[stride];
    p1 = right - P0, p2 = down - P0;
    g11 = G.xx, g12 = G.xy, g22 = G.yy;
  } else {  // corner 0 upper right (s = 0) or lower left
    const double P0 = s ? P[stride] : P[1], down = s ? P[0] : P[stride + 1], left = s ? P[stride + 1] : P[0];
    p1 = down - P0, p2 = left - P0;
    g11 = G.yy, g12 = -G.xy, g22 = G.xx;
  }
  const double first = -(g11 * p1 + g12 * p2), second = -(g12 * p1 + g22 * p2);
  return {-(first + second), first, second};
}

std::int64_t AtlasFlow::across(int t, int k) const {
  if (k == 0) return 4 * std::int64_t(t ^ 1);
  const int cell = t >> 1;
  const Shape& shape = shapes[domain_->diagonal(cell)][t & 1];
  const Side side = k == 1 ? shape.opposite_1 : shape.opposite_2;
  const int there = domain_->beyond(cell, side);
  if (there < 0) return -1;
  const int code = triangle_at(domain_->diagonal(there), opposite(side));
  return 4 * std::int64_t(2 * there + (code >> 1)) + 1 + (code & 1);
}

std::int64_t AtlasFlow::leave(int t, int k) const {
  const std::int64_t code = across(t, k);
  return code >= 0 && rates(int(code >> 2))[std::size_t(code & 3)] > 0 ? code : -1;
}

Vector2 AtlasFlow::corner(int t, int k) const {
  const auto& at = shapes[domain_->diagonal(t >> 1)][t & 1].corners[k];
  return {at[0], at[1]};
}

Vector2 AtlasFlow::velocity(int t) const {
  const std::array<double, 3> rate = rates(t);
  const Vector2 origin = corner(t, 0);
  return rate[1] * (corner(t, 1) - origin) + rate[2] * (corner(t, 2) - origin);
}

/// Of the weight of corner k + 2 on the edge opposite k, from this side alone.
double AtlasFlow::slide_rate_from(int t, int k) const {
  const Vector2 edge = corner(t, before(k)) - corner(t, after(k));
  return velocity(t).dot(edge) / edge.squaredNorm();
}

double AtlasFlow::slide_rate(int t, int k) const {
  const std::int64_t code = across(t, k);
  const int cell = t >> 1, other = code < 0 ? -1 : int(code >> 3);
  const Vector2 first = corner(t, after(k)), edge = corner(t, before(k)) - first;
  if (!potential_.empty()) {
    const int stride = domain_->stride(cell);
    const auto P = [&](const Vector2& at) { return potential_[std::size_t(cell + int(at.x()) + stride * int(at.y()))]; };
    double square = 0, sides = 0;
    for (const int side : {cell, other})
      if (side >= 0 && domain_->covered(side)) {
        square += domain_->metric(side).product(edge, edge);
        ++sides;
      }
    return sides > 0 ? (P(first) - P(first + edge)) * sides / square : 0;
  }
  const double here = slide_rate_from(t, k);
  if (code < 0 || !domain_->covered(other)) return here;
  const int there = int(code >> 2), l = int(code & 3);
  const double pressed = std::max(0.0, -rates(t)[std::size_t(k)]),
               against = std::max(0.0, -rates(there)[std::size_t(l)]);
  const double share = pressed + against > 0 ? against / (pressed + against) : 0.5;
  return share * here - (1 - share) * slide_rate_from(there, l);
}

double AtlasFlow::speed(int t) const {
  const Vector2 X = velocity(t);
  return domain_->covered(t >> 1) ? std::sqrt(domain_->metric(t >> 1).product(X, X)) : 0;
}

/// The fastest way on from the node at corner k of triangle t.
std::int64_t AtlasFlow::exit(int t, int k) const {
  struct Way {
    double speed;
    std::int64_t code;
  };
  constexpr int most = 64;
  std::array<Way, most> ways;
  int count = 0;
  double fastest = 0;
  const auto offer = [&](double speed, int triangle, int corner, walk::Way way) {
    if (!(speed > 0) || count == most) return;
    ways[std::size_t(count++)] = {speed, walk::exit_code(triangle, corner, way)};
    fastest = std::max(fastest, speed);
  };
  const auto look_at = [&](int u, int c) {
    if (!domain_->covered(u >> 1)) return;
    const int next = after(c), previous = before(c);
    const std::array<double, 3> rate = rates(u);
    if (rate[std::size_t(next)] >= 0 && rate[std::size_t(previous)] >= 0) offer(speed(u), u, c, walk::Way::face);
    const auto length = [&](int e) {
      const Vector2 edge = corner(u, before(e)) - corner(u, after(e));
      return std::sqrt(domain_->metric(u >> 1).product(edge, edge));
    };
    const auto presses = [&](int e) { return rate[std::size_t(e)] <= 0 && leave(u, e) < 0; };
    if (presses(previous)) offer(slide_rate(u, previous) * length(previous), u, c, walk::Way::edge_to_next);
    if (presses(next)) offer(-slide_rate(u, next) * length(next), u, c, walk::Way::edge_to_previous);
  };
  // Around the node, over the edges to the next corners, and from where the texture ends the other way.
  const auto turn = [&](bool forwards) {
    int u = t, c = k;
    for (int n = 0; n < 8; ++n) {
      const std::int64_t code = across(u, forwards ? after(c) : before(c));
      if (code < 0) return false;
      u = int(code >> 2);
      c = forwards ? after(int(code & 3)) : before(int(code & 3));
      if (u == t && c == k) return true;
      look_at(u, c);
    }
    return true;
  };
  look_at(t, k);
  if (!turn(true)) turn(false);
  std::int64_t best = walk::rest;
  for (int n = 0; n < count; ++n) {
    const auto& [speed, code] = ways[std::size_t(n)];
    if (!walk::faster(fastest, speed) && (best == walk::rest || code < best)) best = code;
  }
  return best;
}

TracedTexels AtlasFlow::trace(std::span<const ChartPlace> starts, double time, const Progress& progress) const {
  require(time >= 0, fmt::format("a path cannot be followed for a time of {}", time));
  require(std::ssize(starts) < std::numeric_limits<int>::max(), "too many paths for one call");
  for (const ChartPlace& p : starts)
    require(p.cell >= 0 && p.cell < domain_->node_count() && p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1,
            "a path begins outside the textures");
  TracedTexels traced;
  traced.ends.resize(starts.size());
  traced.circled.resize(starts.size());
  std::atomic<std::int64_t> done = 0;
  traced.counts = parallel_sum(
      std::ssize(starts), PathCounts{},
      [&](std::int64_t begin, std::int64_t end) {
        const PathCounts counts = walk::follow<walk::AtlasPath>(
            *this, begin, end, time,
            [&](walk::AtlasPath& path) { walk::put_at(*this, path, starts[std::size_t(path.id)]); },
            [&](const walk::AtlasPath& path) {
              traced.ends[std::size_t(path.id)] = walk::place_of(*this, path);
              traced.circled[std::size_t(path.id)] = path.meetings >= walk::most_meetings ? 1 : 0;
            },
            progress);
        progress.at(double(done += end - begin) / double(starts.size()));
        return counts;
      },
      atlas_block);
  return traced;
}

}  // namespace mq
