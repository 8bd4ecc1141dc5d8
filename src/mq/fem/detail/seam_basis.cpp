// The gradient of φ follows the formula of the header term by term: with q_e = g_e / max g,
//
//     ∇g_e = −∇d_e / d_e²,   ∇q_e = (∇g_e − q_e ∇ max g) / max g,   ∇r_e = 2 (q_e − ½) ∇q_e,
//
// and s_e moves along the seam only where p_e is not an end of it. Below `on_seam` x counts as p_e.

#include "mq/fem/detail/seam_basis.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mq/fem/detail/quadrature.h"

namespace mq {
namespace {

double texels_from(std::int64_t coordinate, int cell) {
  return double(coordinate - std::int64_t(cell) * TexelPoint::one) / double(TexelPoint::one);
}

constexpr double on_seam = 1e-13;        // texels
constexpr double smallest_part = 1e-24;  // texels²; far below `smallest_piece`
constexpr std::size_t few_seams = 4;     // near one cell

/// Of lengths in texels, which neither overflow nor vanish.
double length(double x, double y) { return std::sqrt(x * x + y * y); }

/// Distance of (x, y) from the segment a, a + e.
double segment_distance(double ax, double ay, double ex, double ey, double x, double y) {
  const double s = std::clamp(((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey), 0.0, 1.0);
  return length(x - ax - s * ex, y - ay - s * ey);
}

/// Whether a segment comes within `reach` of the unit square.
bool near_square(double ax, double ay, double ex, double ey, double reach) {
  // Liang and Barsky's clipping: does it meet the square at all?
  double t0 = 0, t1 = 1;
  bool meets = true;
  for (const auto& [p, q] : {std::pair(-ex, ax), {ex, 1 - ax}, {-ey, ay}, {ey, 1 - ay}}) {
    if (p == 0)
      meets = meets && q >= 0;
    else if (p < 0)
      t0 = std::max(t0, q / p);
    else
      t1 = std::min(t1, q / p);
  }
  if (meets && t0 <= t1) return true;
  const auto from_square = [&](double x, double y) {
    return length(x - std::clamp(x, 0.0, 1.0), y - std::clamp(y, 0.0, 1.0));
  };
  double distance = std::min(from_square(ax, ay), from_square(ax + ex, ay + ey));
  for (int k = 0; k < 4; ++k)
    distance = std::min(distance, segment_distance(ax, ay, ex, ey, k & 1, k >> 1));
  return distance < reach;
}

/// Parts of convex polygons on either side of a·x + b·y = c; those the line misses stay whole.
template <class Polygon>
void part(double a, double b, double c, std::vector<Polygon>& polygons) {
  for (std::size_t k = 0, count = polygons.size(); k < count; ++k) {
    Polygon sides[2];
    const Polygon& polygon = polygons[k];
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const auto &p = polygon[i], &q = polygon[i + 1 == polygon.size() ? 0 : i + 1];
      const double dp = a * p[0] + b * p[1] - c, dq = a * q[0] + b * q[1] - c;
      if (dp <= 0) sides[0].push_back(p);
      if (dp >= 0) sides[1].push_back(p);
      if (dp * dq >= 0) continue;
      const double t = dp / (dp - dq);
      for (Polygon& side : sides)
        side.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
    }
    if (sides[0].size() < 3 || sides[1].size() < 3) continue;
    polygons[k] = std::move(sides[0]);
    polygons.push_back(std::move(sides[1]));
  }
}

/// The centroid of the area: two corners that rounding makes one or two do not move it.
template <class Polygon>
std::array<double, 2> centroid(const Polygon& polygon) {
  const auto& o = polygon[0];
  double area = 0, x = 0, y = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const double ux = polygon[k - 1][0] - o[0], uy = polygon[k - 1][1] - o[1];
    const double vx = polygon[k][0] - o[0], vy = polygon[k][1] - o[1];
    const double twice = ux * vy - uy * vx;
    area += twice, x += twice * (ux + vx), y += twice * (uy + vy);
  }
  if (area == 0) return o;
  return {o[0] + x / (3 * area), o[1] + y / (3 * area)};
}

}  // namespace

// ------------------------------------------------------------------------------------- near seams

NearSeams::NearSeams(const Atlas& atlas, const Seams& seams) {
  constexpr double reach = Seams::blend;
  for (int e = 0; e < seams.count(); ++e)
    for (HalfEdge h : seams.half_edges(e)) {
      const auto& corners = atlas.corners[h / 3];
      TexelPoint a = corners[h % 3], b = corners[next(h) % 3];
      if (b.y < a.y) std::swap(a, b);
      const double slope = b.y == a.y ? 0 : double(b.x - a.x) / double(b.y - a.y);
      const int first = int(std::floor(a.row() - reach)), last = int(std::floor(b.row() + reach));
      for (int row = first; row <= last; ++row) {
        double x0 = a.column(), x1 = b.column();
        if (b.y != a.y) {  // the part of the segment within reach of the row
          const double y0 = std::clamp(row - reach, a.row(), b.row());
          const double y1 = std::clamp(row + 1 + reach, a.row(), b.row());
          x1 = x0 + (y1 - a.row()) * slope;
          x0 = x0 + (y0 - a.row()) * slope;
        }
        if (x1 < x0) std::swap(x0, x1);
        for (int c = int(std::floor(x0 - reach)); c <= int(std::floor(x1 + reach)); ++c) {
          const double ax = texels_from(a.x, c), ay = texels_from(a.y, row);
          if (near_square(ax, ay, texels_from(b.x, c) - ax, texels_from(b.y, row) - ay, reach))
            entries_.push_back({atlas.chart[h / 3], row, c, h});
        }
      }
    }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& p, const Entry& q) {
    return std::tie(p.chart, p.row, p.column, p.half_edge) <
           std::tie(q.chart, q.row, q.column, q.half_edge);
  });
  chart_offsets_.assign(atlas.charts.size() + 1, 0);
  for (const Entry& entry : entries_) ++chart_offsets_[entry.chart + 1];
  for (std::size_t c = 1; c < chart_offsets_.size(); ++c)
    chart_offsets_[c] += chart_offsets_[c - 1];
}

std::span<const NearSeams::Entry> NearSeams::row(int chart, int row) const {
  const auto begin = entries_.begin() + chart_offsets_[chart];
  const auto end = entries_.begin() + chart_offsets_[chart + 1];
  const auto from =
      std::lower_bound(begin, end, row, [](const Entry& e, int r) { return e.row < r; });
  const auto to = std::upper_bound(from, end, row, [](int r, const Entry& e) { return r < e.row; });
  return {from, to};
}

std::span<const NearSeams::Entry> NearSeams::cell(std::span<const Entry> row, int column) {
  const auto from = std::lower_bound(row.begin(), row.end(), column,
                                     [](const Entry& e, int c) { return e.column < c; });
  auto to = from;
  while (to != row.end() && to->column == column) ++to;
  return row.subspan(from - row.begin(), to - from);
}

// ------------------------------------------------------------------------------------------ curves

void SeamCell::start(int texture, int column, int row, std::span<const NearSeams::Entry> near) {
  segments_.clear();
  half_edges_.clear();
  curves_.clear();
  entries_.clear();
  terms_.clear();
  triangles_.clear();
  x_.clear();
  y_.clear();
  weights_.clear();
  first_terms_.assign(1, 0);
  texels_.clear();
  const auto corners = grid_.corners(texture, column, row);
  for (int k = 0; k < 4; ++k) corner_[k] = texel(corners[k]);
  for (const NearSeams::Entry& entry : near) {
    const HalfEdge h = entry.half_edge;
    const auto& places = atlas_.corners[h / 3];
    const TexelPoint &a = places[h % 3], &b = places[next(h) % 3];
    Segment e{texels_from(a.x, column), texels_from(a.y, row), 0, 0, 0};
    e.ex = texels_from(b.x, column) - e.ax, e.ey = texels_from(b.y, row) - e.ay;
    e.square = e.ex * e.ex + e.ey * e.ey;
    segments_.push_back(e);
    half_edges_.push_back(h);
  }
}

int SeamCell::texel(int number) {
  for (std::size_t k = 0; k < texels_.size(); ++k)
    if (texels_[k] == number) return int(k);
  texels_.push_back(number);
  return int(texels_.size()) - 1;
}

/// Adds a term as quadratics of its texels: with x = x_0 + x' s, y likewise, s from the middle,
/// (weight + rate s) (1 − x or x) (1 − y or y); one of rate and (x', y') is zero.
void SeamCell::add_bilinear(const SeamTerm& term) {
  const TexturePlace& p = term.place;
  for (int k = 0; k < 4; ++k) {
    const double bx = k & 1 ? p.x : 1 - p.x, by = k >> 1 ? p.y : 1 - p.y;
    const double bx1 = k & 1 ? term.x_rate : -term.x_rate,
                 by1 = k >> 1 ? term.y_rate : -term.y_rate;
    const double b0 = bx * by, b1 = bx * by1 + bx1 * by, b2 = bx1 * by1;
    if (b0 == 0 && b1 == 0 && b2 == 0) continue;
    entries_.push_back({texel(grid_.texel(p.texture, p.column + (k & 1), p.row + (k >> 1))),
                        term.weight * b0, term.weight * b1 + term.rate * b0, term.weight * b2});
  }
}

/// The curve of a segment that holds parameter s of its seam, made when first asked for.
int SeamCell::curve_at(int segment, double s) {
  for (std::size_t c = 0; c < curves_.size(); ++c)
    if (curves_[c].segment == segment && curves_[c].begin <= s && s <= curves_[c].end)
      return int(c);
  const HalfEdge h = half_edges_[segment];
  const int seam = seams_.seam(h);
  const auto breaks = seams_.breaks(seam);
  const auto above = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, s);
  Curve curve{segment, above[-1], *above, 0.5 * (above[-1] + *above), int(entries_.size()), 0};
  value_.clear();
  seams_.add_value(seam, curve.middle, value_);
  value_[seams_.is_first(h) ? 0 : 1].weight -= 1;  // of the chart's own side, whose values σ is the difference from
  for (const SeamTerm& term : value_) add_bilinear(term);
  int end = curve.first_entry;  // entries of one texel become one
  for (int k = end; k < int(entries_.size()); ++k) {
    int j = curve.first_entry;
    while (j < end && entries_[j].texel != entries_[k].texel) ++j;
    if (j == end)
      entries_[end++] = entries_[k];
    else
      entries_[j].c0 += entries_[k].c0, entries_[j].c1 += entries_[k].c1,
          entries_[j].c2 += entries_[k].c2;
  }
  entries_.resize(end);
  curve.end_entry = end;
  curves_.push_back(curve);
  return int(curves_.size()) - 1;
}

// ------------------------------------------------------------------------------------------ points

void SeamCell::add_point(int triangle, double x, double y, double weight) {
  triangles_.push_back(triangle);
  x_.push_back(x);
  y_.push_back(y);
  weights_.push_back(weight);
}

/// Finds the terms of the points added since it was last called.
void SeamCell::weigh_points() {
  constexpr std::size_t step = SeamWeights::points;
  if (near_.size() <= segments_.size()) near_.resize(segments_.size() + 1);
  for (std::size_t begin = first_terms_.size() - 1; begin < x_.size(); begin += step) {
    const std::size_t count = std::min(step, x_.size() - begin);
    double x[step], y[step];
    for (std::size_t k = 0; k < step; ++k) {
      x[k] = x_[begin + std::min(k, count - 1)];
      y[k] = y_[begin + std::min(k, count - 1)];
    }
    const int near = seam_kernels().weights(segments_.data(), int(segments_.size()), x, y, Seams::blend, on_seam,
                                            near_.data());
    for (std::size_t k = 0; k < count; ++k) {
      for (int n = 0; n < near; ++n) {
        const SeamWeights& w = near_[std::size_t(n)];
        if (!(w.lambda[k] > 0)) continue;
        const bool first = seams_.is_first(half_edges_[std::size_t(w.segment)]);
        const double s = first ? w.s[k] : 1 - w.s[k];
        const int curve = curve_at(w.segment, s);
        terms_.push_back({curve, s - curves_[std::size_t(curve)].middle, first ? w.s_x[k] : -w.s_x[k],
                          first ? w.s_y[k] : -w.s_y[k], w.lambda[k], w.lambda_x[k], w.lambda_y[k]});
      }
      first_terms_.push_back(int(terms_.size()));
    }
  }
}

namespace {

/// Texels whose terms cancel take no part: they would be unknowns that nothing determines.
void drop_zero_columns(BasisSamples& samples) {
  std::vector<int> kept, texels;
  for (int k = 0; k < int(samples.texels.size()); ++k) {
    if (samples.values.col(k).isZero(0) && samples.dx.col(k).isZero(0) &&
        samples.dy.col(k).isZero(0))
      continue;
    kept.push_back(k);
    texels.push_back(samples.texels[k]);
  }
  if (kept.size() == samples.texels.size()) return;
  samples.texels = texels;
  for (BasisSamples::Matrix* matrix : {&samples.values, &samples.dx, &samples.dy})
    *matrix = BasisSamples::Matrix((*matrix)(Eigen::all, kept));
}

}  // namespace

template <class Visit>
void SeamCell::for_each_texel(std::size_t point, const Visit& visit) const {
  for (const int corner : corner_) visit(corner);
  for (int t = first_terms_[point]; t < first_terms_[point + 1]; ++t) {
    const Curve& curve = curves_[terms_[t].curve];
    for (int k = curve.first_entry; k < curve.end_entry; ++k) visit(entries_[k].texel);
  }
}

/// The texels of the points from `first` on, as many points as have no more of them than asked for
/// together (one at least). Returns one past the last of these points.
std::size_t SeamCell::choose_texels(std::size_t first, std::size_t most_texels,
                                    std::vector<int>& chosen) {
  weigh_points();
  if (first == 0 && texels_.size() <= most_texels) {
    local_.resize(texels_.size());
    std::iota(local_.begin(), local_.end(), 0);
    chosen = local_;
    return point_count();
  }
  local_.assign(texels_.size(), -1);
  std::size_t end = first;
  for (; end < point_count(); ++end) {
    const std::size_t before = chosen.size();
    for_each_texel(end, [&](int texel) {
      if (local_[texel] >= 0) return;
      local_[texel] = int(chosen.size());
      chosen.push_back(texel);
    });
    if (chosen.size() <= most_texels || end == first) continue;
    for (std::size_t k = before; k < chosen.size(); ++k) local_[chosen[k]] = -1;
    chosen.resize(before);
    break;
  }
  return end;
}

std::size_t SeamCell::evaluate(BasisSamples& samples, std::size_t first, std::size_t most_texels) {
  samples.texels.clear();
  const std::size_t last = choose_texels(first, most_texels, samples.texels);
  const Eigen::Index count = std::ssize(samples.texels), points = Eigen::Index(last - first);
  for (int& texel : samples.texels) texel = texels_[texel];
  samples.triangles.resize(points);
  samples.weights.resize(points);
  samples.places.resize(points);
  samples.values.setZero(points, count);
  samples.dx.setZero(points, count);
  samples.dy.setZero(points, count);
  for (Eigen::Index q = 0; q < points; ++q) {
    const std::size_t number = first + std::size_t(q);
    const double x = x_[number], y = y_[number];
    samples.triangles[q] = triangles_[number];
    samples.weights[q] = weights_[number];
    samples.places[q] = {x, y};
    double *value = samples.values.row(q).data(), *dx = samples.dx.row(q).data(),
           *dy = samples.dy.row(q).data();
    for (int k = 0; k < 4; ++k) {
      const double fx = k & 1 ? x : 1 - x, fy = k >> 1 ? y : 1 - y;
      const int at = local_[corner_[k]];
      value[at] += fx * fy;
      dx[at] += (k & 1 ? 1 : -1) * fy;
      dy[at] += (k >> 1 ? 1 : -1) * fx;
    }
    for (int t = first_terms_[number]; t < first_terms_[number + 1]; ++t) {
      const Term& term = terms_[t];
      const Curve& curve = curves_[term.curve];
      for (int k = curve.first_entry; k < curve.end_entry; ++k) {
        const CurveEntry& e = entries_[k];
        const double c = e.c0 + term.s * (e.c1 + term.s * e.c2), slope = e.c1 + 2 * term.s * e.c2;
        const int at = local_[e.texel];
        value[at] += term.lambda * c;
        dx[at] += term.lambda_x * c + term.lambda * slope * term.s_x;
        dy[at] += term.lambda_y * c + term.lambda * slope * term.s_y;
      }
    }
  }
  drop_zero_columns(samples);
  return last;
}

// ------------------------------------------------------------------------------------------ pieces

SeamCell::Polygon SeamCell::outline(int triangle, const Piece& piece) const {
  Polygon points;
  std::vector<double> cuts;
  for (int k = 0; k < piece.count; ++k) {
    const Piece::Vertex &v = piece.vertices[k],
                        &w = piece.vertices[k + 1 == piece.count ? 0 : k + 1];
    points.push_back({v.x, v.y});
    const HalfEdge h = 3 * triangle + v.side;
    if (v.side < 0 || seams_.seam(h) < 0) continue;
    const auto at = std::ranges::find(half_edges_, h);
    if (at == half_edges_.end()) continue;
    const Segment& e = segments_[std::size_t(at - half_edges_.begin())];
    const bool wide = std::abs(e.ex) > std::abs(e.ey), first = seams_.is_first(h);
    const auto parameter = [&](const Piece::Vertex& p) {
      const double s = wide ? (p.x - e.ax) / e.ex : (p.y - e.ay) / e.ey;
      return first ? s : 1 - s;
    };
    const double from = parameter(v), to = parameter(w);
    const auto breaks = seams_.breaks(seams_.seam(h));
    cuts.clear();
    for (auto b = std::upper_bound(breaks.begin(), breaks.end(), std::min(from, to));
         b != breaks.end() && *b < std::max(from, to); ++b)
      cuts.push_back(*b);
    if (to < from) std::reverse(cuts.begin(), cuts.end());
    for (double s : cuts) {
      const double t = first ? s : 1 - s;
      points.push_back({e.ax + t * e.ex, e.ay + t * e.ey});
    }
  }
  return points;
}

/// Whether a seam comes within η of a convex polygon, by the distances of corners from sides and
/// of ends from sides; a seam that crosses the polygon bounds it too.
bool SeamCell::reaches(const Polygon& polygon) const {
  constexpr double eta = Seams::blend - 1e-9;
  for (const Segment& e : segments_) {
    for (const auto& p : polygon)
      if (segment_distance(e.ax, e.ay, e.ex, e.ey, p[0], p[1]) < eta) return true;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const auto &p = polygon[k], &q = polygon[k + 1 == polygon.size() ? 0 : k + 1];
      const double px = q[0] - p[0], py = q[1] - p[1];
      if (px == 0 && py == 0) continue;
      if (segment_distance(p[0], p[1], px, py, e.ax, e.ay) < eta ||
          segment_distance(p[0], p[1], px, py, e.ax + e.ex, e.ay + e.ey) < eta)
        return true;
    }
  }
  return false;
}

void SeamCell::add_piece(int triangle, const Piece& piece, std::vector<Polygon>& bilinear) {
  std::vector<Polygon> parts{outline(triangle, piece)};
  if (segments_.size() <= few_seams)
    for (const Segment& e : segments_) {
      const double size = std::sqrt(e.square), a = -e.ey / size, b = e.ex / size;
      const double at = a * e.ax + b * e.ay;
      part(a, b, at + Seams::blend, parts);
      part(a, b, at - Seams::blend, parts);
    }
  for (Polygon& polygon : parts) {
    if (!reaches(polygon)) {
      bilinear.push_back(std::move(polygon));
      continue;
    }
    const auto [cx, cy] = centroid(polygon);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const auto &p = polygon[k], &q = polygon[k + 1 == polygon.size() ? 0 : k + 1];
      const double area = std::abs((p[0] - cx) * (q[1] - cy) - (p[1] - cy) * (q[0] - cx)) / 2;
      if (area < smallest_part) continue;
      for (const TrianglePoint& r : triangle_rule_4())
        add_point(triangle, r.l0 * cx + r.l1 * p[0] + r.l2 * q[0],
                  r.l0 * cy + r.l1 * p[1] + r.l2 * q[1], r.weight * area);
    }
  }
}

}  // namespace mq
