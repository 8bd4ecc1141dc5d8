#include "mq/baseline/quadratic_seam_basis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "mq/atlas/clip.h"
#include "mq/atlas/seams.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using Point = std::array<double, 2>;

constexpr double same_point = 1e-9;  ///< texels

double twice_area(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double twice_area(const std::vector<Point>& polygon) {
  double sum = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) sum += twice_area(polygon[0], polygon[k - 1], polygon[k]);
  return sum;
}

/// Whether d lies inside the circle through a, b, c, which turn the positive way.
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto row = [&](const Point& p) {
    const double x = p[0] - d[0], y = p[1] - d[1];
    return std::array{x, y, x * x + y * y};
  };
  const auto [ax, ay, aw] = row(a);
  const auto [bx, by, bw] = row(b);
  const auto [cx, cy, cw] = row(c);
  return ax * (by * cw - bw * cy) - ay * (bx * cw - bw * cx) + aw * (bx * cy - by * cx) > 1e-14;
}

/// The least height of a triangle by its longest side: how good an ear it is.
double fatness(const Point& a, const Point& b, const Point& c) {
  const auto side = [](const Point& p, const Point& q) { return std::hypot(q[0] - p[0], q[1] - p[1]); };
  const double longest = std::max({side(a, b), side(b, c), side(c, a)});
  return longest > 0 ? twice_area(a, b, c) / (longest * longest) : 0;
}

using Corners = std::array<std::size_t, 3>;

/// Triangles of a polygon without holes that turns the positive way: ears cut off, the fattest first.
std::vector<Corners> ears(const std::vector<Point>& polygon) {
  std::vector<std::size_t> left(polygon.size());
  for (std::size_t k = 0; k < left.size(); ++k) left[k] = k;
  std::vector<Corners> triangles;
  while (left.size() >= 3) {
    std::size_t best = left.size();
    double most = 1e-12;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const Corners ear{left[(k + left.size() - 1) % left.size()], left[k], left[(k + 1) % left.size()]};
      const Point &a = polygon[ear[0]], &b = polygon[ear[1]], &c = polygon[ear[2]];
      if (const double value = fatness(a, b, c); value > most) {
        const bool covers = std::ranges::any_of(left, [&](std::size_t other) {
          if (std::ranges::count(ear, other)) return false;
          const Point& p = polygon[other];
          return twice_area(a, b, p) >= -1e-15 && twice_area(b, c, p) >= -1e-15 && twice_area(c, a, p) >= -1e-15;
        });
        if (!covers) best = k, most = value;
      }
    }
    if (best == left.size()) break;  // what is left has no area
    triangles.push_back({left[(best + left.size() - 1) % left.size()], left[best], left[(best + 1) % left.size()]});
    left.erase(left.begin() + std::ptrdiff_t(best));
  }
  return triangles;
}

/// Sides that two triangles share are turned until the circles around both are empty of the other.
void turn_sides(const std::vector<Point>& points, std::vector<Corners>& triangles) {
  for (std::size_t tries = 0; tries < points.size() * points.size(); ++tries) {
    bool changed = false;
    for (std::size_t s = 0; s < triangles.size() && !changed; ++s)
      for (std::size_t t = 0; t < triangles.size() && !changed; ++t)
        for (std::size_t i = 0; i < 3 && !changed; ++i)
          for (std::size_t j = 0; j < 3 && !changed; ++j) {
            Corners &a = triangles[s], &b = triangles[t];
            if (s == t || a[i] != b[(j + 1) % 3] || a[(i + 1) % 3] != b[j]) continue;
            const std::size_t p = a[i], q = a[(i + 1) % 3], r = a[(i + 2) % 3], o = b[(j + 2) % 3];
            if (!in_circle(points[p], points[q], points[r], points[o])) continue;
            if (fatness(points[p], points[o], points[r]) < 1e-12 || fatness(points[o], points[q], points[r]) < 1e-12) continue;
            a = {p, o, r};
            b = {o, q, r};
            changed = true;
          }
    if (!changed) return;
  }
}

/// The part of a convex polygon to the left of a → b.
std::vector<Point> left_of(const std::vector<Point>& polygon, const Point& a, const Point& b) {
  std::vector<Point> part;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Point &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const double at_p = twice_area(a, b, p), at_q = twice_area(a, b, q);
    if (at_p >= 0) part.push_back(p);
    if (at_p * at_q < 0) {
      const double s = at_p / (at_p - at_q);
      part.push_back({p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])});
    }
  }
  return part;
}

/// Calls visit(point, weight): three by three Gauss points on each triangle of a fan, exact to degree 4.
template <class Visit>
void integrate(const std::vector<Point>& polygon, const Visit& visit) {
  const double root = std::sqrt(0.6);
  const std::array<double, 3> at{(1 - root) / 2, 0.5, (1 + root) / 2}, weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const Point &o = polygon[0], &p = polygon[k - 1], &q = polygon[k];
    const double area = twice_area(o, p, q);
    if (!(area > 0)) continue;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const double s = at[i], t = at[j] * (1 - s);
        visit(Point{o[0] + s * (p[0] - o[0]) + t * (q[0] - o[0]), o[1] + s * (p[1] - o[1]) + t * (q[1] - o[1])},
              weight[i] * weight[j] * (1 - s) * area);
      }
  }
}

/// Quadratic elements at a point: values, and slopes by x and y.
struct Elements {
  std::array<double, 6> value, dx, dy;

  Elements(const std::array<Point, 3>& corners, const Point& p) {
    const double area = twice_area(corners[0], corners[1], corners[2]);
    std::array<double, 3> l, lx, ly;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &a = corners[(k + 1) % 3], &b = corners[(k + 2) % 3];
      l[k] = twice_area(a, b, p) / area;
      lx[k] = (a[1] - b[1]) / area;
      ly[k] = (b[0] - a[0]) / area;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t n = (k + 1) % 3;
      value[k] = l[k] * (2 * l[k] - 1);
      dx[k] = (4 * l[k] - 1) * lx[k];
      dy[k] = (4 * l[k] - 1) * ly[k];
      value[3 + k] = 4 * l[k] * l[n];
      dx[3 + k] = 4 * (lx[k] * l[n] + l[k] * lx[n]);
      dy[3 + k] = 4 * (ly[k] * l[n] + l[k] * ly[n]);
    }
  }
};

void add(std::vector<BasisWeight>& sum, const std::vector<BasisWeight>& more, double factor) {
  for (const auto& [unknown, weight] : more) {
    const auto at = std::ranges::find(sum, unknown, &BasisWeight::unknown);
    if (at == sum.end())
      sum.push_back({unknown, factor * weight});
    else
      at->weight += factor * weight;
  }
}

}  // namespace

/// What of a chart lies in a cell, as one line around it.
struct ChartOutline {
  int texture = 0, column = 0, row = 0;
  std::vector<Point> points;
  std::vector<std::vector<TexturePlace>> copies;  ///< of points on seams; else none
  std::vector<std::vector<TexturePlace>> middles;  ///< of the middles of sides to the next point, where these are on seams
};

namespace {

/// All that triangles of a chart cut out of one cell, as sides between points.
class CellSides {
 public:
  struct Vertex {
    Point at;
    std::vector<TexturePlace> copies;
  };
  struct Side {
    std::size_t from, to;
    HalfEdge seam;
    double begin, end;
    bool is_border;
  };

  std::size_t point(const Point& p) {
    for (std::size_t k = 0; k < vertices.size(); ++k)
      if (std::abs(vertices[k].at[0] - p[0]) < same_point && std::abs(vertices[k].at[1] - p[1]) < same_point) return k;
    vertices.push_back({p, {}});
    return vertices.size() - 1;
  }

  /// Sides that triangles share go.
  void add_side(const Side& side) {
    if (side.from == side.to) return;
    const auto twin = std::ranges::find_if(sides, [&](const Side& s) { return s.from == side.to && s.to == side.from; });
    if (twin == sides.end())
      sides.push_back(side);
    else
      sides.erase(twin);
  }

  std::vector<Vertex> vertices;
  std::vector<Side> sides;
};

std::map<int, std::vector<TexturePlace>> places_of_vertices(const Surface& surface, const Atlas& atlas) {
  std::map<int, std::set<std::array<std::int64_t, 3>>> found;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && atlas.chart[std::size_t(t)] >= 0; ++k) {
      const TexelPoint& p = atlas.corners[std::size_t(t)][k];
      found[surface.mesh.triangles[t][k]].insert({surface.mesh.texture(t), p.x, p.y});
    }
  std::map<int, std::vector<TexturePlace>> places;
  for (const auto& [vertex, corners] : found) {
    if (corners.size() < 2) continue;
    for (const auto& [texture, x, y] : corners)
      places[vertex].push_back({int(texture), floor_texel(x), floor_texel(y),
                                double(x & (TexelPoint::one - 1)) / double(TexelPoint::one),
                                double(y & (TexelPoint::one - 1)) / double(TexelPoint::one)});
  }
  return places;
}

/// The sides of a piece, with those on seams cut where either side crosses a texel line.
class PieceSides {
 public:
  PieceSides(const Surface& surface, const Atlas& atlas, const Seams& seams)
      : surface_(surface), atlas_(atlas), seams_(seams), places_(places_of_vertices(surface, atlas)) {}

  void add(int t, const Piece& piece, CellSides& cell) const {
    std::vector<Point> around;
    for (int k = 0; k < piece.count; ++k) around.push_back({piece.vertices[k].x, piece.vertices[k].y});
    const bool turned = twice_area(around) < 0;
    for (int k = 0; k < piece.count; ++k) {
      const Piece::Vertex &v = piece.vertices[k], &w = piece.vertices[(k + 1) % piece.count];
      const std::size_t from = vertex(t, v, cell), to = vertex(t, w, cell);
      const HalfEdge h = v.side < 0 ? -1 : 3 * t + v.side;
      if (h < 0 || atlas_.edges[std::size_t(h)] == EdgeKind::inside || seams_.seam(h) < 0) {
        const bool border = h >= 0 && atlas_.edges[std::size_t(h)] != EdgeKind::inside;
        cell.add_side(turned ? CellSides::Side{to, from, -1, 0, 0, border} : CellSides::Side{from, to, -1, 0, 0, border});
        continue;
      }
      add_on_seam(h, piece, from, to, turned, cell);
    }
  }

 private:
  std::size_t vertex(int t, const Piece::Vertex& v, CellSides& cell) const {
    const std::size_t k = cell.point({v.x, v.y});
    if (v.corner >= 0)
      if (const auto at = places_.find(surface_.mesh.triangles[t][v.corner]); at != places_.end()) cell.vertices[k].copies = at->second;
    return k;
  }

  /// The parameter of a seam at a point of the cell.
  double parameter(HalfEdge h, const Piece& piece, const Point& p) const {
    const TexturePlace a = seams_.place(h, 0), b = seams_.place(h, 1);
    const double ax = a.column + a.x - piece.column, ay = a.row + a.y - piece.row;
    const double ex = b.column + b.x - piece.column - ax, ey = b.row + b.y - piece.row - ay;
    return std::clamp(std::abs(ex) > std::abs(ey) ? (p[0] - ax) / ex : (p[1] - ay) / ey, 0.0, 1.0);
  }

  std::vector<TexturePlace> both_sides(HalfEdge h, double s) const {
    const auto [first, second] = seams_.half_edges(seams_.seam(h));
    return {seams_.place(first, s), seams_.place(second, s)};
  }

  void add_on_seam(HalfEdge h, const Piece& piece, std::size_t from, std::size_t to, bool turned, CellSides& cell) const {
    const double begin = parameter(h, piece, cell.vertices[from].at), end = parameter(h, piece, cell.vertices[to].at);
    std::vector<std::pair<double, std::size_t>> along{{begin, from}, {end, to}};
    for (const double s : seams_.breaks(seams_.seam(h))) {
      if (!(s > std::min(begin, end) && s < std::max(begin, end))) continue;
      const TexturePlace p = seams_.place(h, s);
      along.push_back({s, cell.point({p.column - piece.column + p.x, p.row - piece.row + p.y})});
    }
    std::ranges::sort(along);
    if (begin > end) std::ranges::reverse(along);
    for (const auto& [s, k] : along)
      if (cell.vertices[k].copies.empty()) cell.vertices[k].copies = both_sides(h, s);
    for (std::size_t k = 1; k < along.size(); ++k) {
      const auto &a = along[k - 1], &b = along[k];
      cell.add_side(turned ? CellSides::Side{b.second, a.second, h, b.first, a.first, true}
                           : CellSides::Side{a.second, b.second, h, a.first, b.first, true});
    }
  }

  const Surface& surface_;
  const Atlas& atlas_;
  const Seams& seams_;
  std::map<int, std::vector<TexturePlace>> places_;
};

bool is_lattice_corner(const Point& p) {
  const auto on = [](double x) { return std::abs(x) < same_point || std::abs(x - 1) < same_point; };
  return on(p[0]) && on(p[1]);
}

/// What is left of the sides of all pieces runs around the part of the chart; points on lattice lines that only triangles of
/// the surface put there are no vertices.
ChartOutline outline_of(const CellSides& cell, const Seams& seams) {
  std::map<std::size_t, std::size_t> leaving;
  for (std::size_t k = 0; k < cell.sides.size(); ++k)
    if (!leaving.emplace(cell.sides[k].from, k).second)
      throw Unsupported("a chart touches itself in a point of a cell: the published basis is not made for that");
  ChartOutline outline;
  std::vector<std::size_t> around;
  for (std::size_t side = leaving.begin()->second; around.size() <= cell.sides.size();) {
    around.push_back(side);
    side = leaving.at(cell.sides[side].to);
    if (side == around.front()) break;
  }
  if (around.size() != cell.sides.size())
    throw Unsupported("a chart has several parts, or a hole, in one cell: the published basis is not made for that");
  for (std::size_t k = 0; k < around.size(); ++k) {
    const CellSides::Side &before = cell.sides[around[(k + around.size() - 1) % around.size()]], &side = cell.sides[around[k]];
    const CellSides::Vertex& vertex = cell.vertices[side.from];
    if (!before.is_border && !side.is_border && vertex.copies.empty() && !is_lattice_corner(vertex.at)) continue;
    outline.points.push_back(vertex.at);
    outline.copies.push_back(vertex.copies);
    std::vector<TexturePlace> middle;
    if (side.seam >= 0)
      for (const HalfEdge h : seams.half_edges(seams.seam(side.seam))) middle.push_back(seams.place(h, (side.begin + side.end) / 2));
    outline.middles.push_back(std::move(middle));
  }
  return outline;
}

}  // namespace

QuadraticSeamBasis::Node QuadraticSeamBasis::bilinear_at(int texture, double column, double row) {
  const int i = int(std::floor(column)), j = int(std::floor(row));
  const double x = column - i, y = row - j;
  Node node;
  for (int k = 0; k < 4; ++k) {
    const double weight = (k & 1 ? x : 1 - x) * (k & 2 ? y : 1 - y);
    if (weight != 0) add(node, {{number(texture, i + (k & 1), j + (k >> 1)), weight}}, 1);
  }
  return node;
}

int QuadraticSeamBasis::number(int texture, int column, int row) {
  const TextureSize& size = atlas_.textures[std::size_t(texture)];
  const std::array<int, 3> texel{texture, std::clamp(column, 0, size.width - 1), std::clamp(row, 0, size.height - 1)};
  const auto [at, is_new] = numbers_.try_emplace(texel, int(texels_.size()));
  if (is_new) texels_.push_back(texel);
  return at->second;
}

/// At a point of the outline, or in the middle between two.
QuadraticSeamBasis::Node QuadraticSeamBasis::node_at(const ChartOutline& outline, std::size_t point, std::size_t next) {
  const bool is_side = next == (point + 1) % outline.points.size();
  const std::vector<TexturePlace>& copies = next == point ? outline.copies[point] : outline.middles[point];
  if (copies.empty() || (next != point && !is_side)) {
    const Point &p = outline.points[point], &q = outline.points[next];
    return bilinear_at(outline.texture, outline.column + (p[0] + q[0]) / 2, outline.row + (p[1] + q[1]) / 2);
  }
  Node node;
  for (const TexturePlace& place : copies)
    add(node, bilinear_at(place.texture, place.column + place.x, place.row + place.y),
        values_ == Values::sum ? 1.0 : 1.0 / double(copies.size()));
  return node;
}

void QuadraticSeamBasis::add_elements(const ChartOutline& outline, Cell& cell) {
  std::vector<Corners> triangles = ears(outline.points);
  turn_sides(outline.points, triangles);
  for (const Corners& corners : triangles) {
    Element element;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = corners[k], q = corners[(k + 1) % 3], r = corners[(k + 2) % 3];
      element.corners[k] = outline.points[p];
      element.nodes[k] = node_at(outline, p, p);
      element.nodes[3 + k] = node_at(outline, p, q);
      const bool on_seam = q == (p + 1) % outline.points.size() && !outline.middles[p].empty();
      if (on_seam && outline.copies[r].empty())
        nearest_node_ = std::min(nearest_node_, twice_area(outline.points[p], outline.points[q], outline.points[r]) /
                                                    std::hypot(outline.points[q][0] - outline.points[p][0],
                                                               outline.points[q][1] - outline.points[p][1]));
    }
    cell.elements.push_back(std::move(element));
  }
}

QuadraticSeamBasis::QuadraticSeamBasis(const Surface& surface, const Atlas& atlas, Values values)
    : surface_(surface), atlas_(atlas), values_(values), nearest_node_(std::numeric_limits<double>::infinity()) {
  const Seams seams(surface, atlas);
  const PieceSides sides(surface, atlas, seams);
  std::map<std::array<int, 3>, CellSides> drawn;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (atlas.chart[std::size_t(t)] < 0) continue;
    const auto add_piece = [&](const Piece& piece) {
      const std::array<int, 3> key{atlas.chart[std::size_t(t)], piece.row, piece.column};
      std::vector<Point> polygon;
      for (int k = 0; k < piece.count; ++k) polygon.push_back({piece.vertices[k].x, piece.vertices[k].y});
      if (twice_area(polygon) < 0) std::ranges::reverse(polygon);
      cells_[key].pieces.emplace_back(t, std::move(polygon));
      sides.add(t, piece, drawn[key]);
    };
    const auto& corners = atlas.corners[std::size_t(t)];
    const auto [first, end] = rows_of(corners);
    for (int row = first; row < end; ++row)
      clip_row(corners, row, add_piece, [&](int at, int from, int to) {
        for (int column = from; column <= to; ++column) add_piece(whole_cell(at, column));
      });
  }
  for (const auto& [key, cell] : drawn) {
    if (cell.sides.empty()) continue;
    ChartOutline outline = outline_of(cell, seams);
    outline.texture = atlas.charts[std::size_t(key[0])].texture;
    outline.row = key[1];
    outline.column = key[2];
    add_elements(outline, cells_[key]);
  }
}

SparseMatrix QuadraticSeamBasis::system(double a, double b) const {
  Entries entries;
  for (const auto& [key, cell] : cells_)
    for (const auto& [triangle, piece] : cell.pieces) {
      const TexelMetric metric = texel_metric(surface_, atlas_, triangle);
      for (const Element& element : cell.elements) {
        std::vector<Point> part = piece;
        for (std::size_t k = 0; k < 3 && part.size() >= 3; ++k) part = left_of(part, element.corners[k], element.corners[(k + 1) % 3]);
        if (part.size() < 3) continue;
        // Of the six elements, then of the texels behind them.
        Eigen::Matrix<double, 6, 6> local = Eigen::Matrix<double, 6, 6>::Zero();
        integrate(part, [&](const Point& p, double weight) {
          const Elements q(element.corners, p);
          for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < 6; ++j)
              local(Eigen::Index(i), Eigen::Index(j)) +=
                  weight * (a * metric.density * q.value[i] * q.value[j] +
                            b * (metric.a * q.dx[i] * q.dx[j] + metric.b * (q.dx[i] * q.dy[j] + q.dy[i] * q.dx[j]) +
                                 metric.c * q.dy[i] * q.dy[j]));
        });
        for (std::size_t i = 0; i < 6; ++i)
          for (std::size_t j = 0; j < 6; ++j)
            for (const auto& [s, at_s] : element.nodes[i])
              for (const auto& [t, at_t] : element.nodes[j])
                entries.emplace_back(s, t, at_s * at_t * local(Eigen::Index(i), Eigen::Index(j)));
      }
    }
  return sparse_matrix(size(), size(), entries);
}

std::vector<BasisWeight> QuadraticSeamBasis::basis_at(int triangle, const Vector3& barycentric) const {
  require(triangle >= 0 && triangle < surface_.triangle_count() && atlas_.chart[std::size_t(triangle)] >= 0,
          fmt::format("triangle {} has no chart", triangle));
  double column = 0, row = 0;
  for (int k = 0; k < 3; ++k) {
    column += barycentric[k] * atlas_.corners[std::size_t(triangle)][k].column();
    row += barycentric[k] * atlas_.corners[std::size_t(triangle)][k].row();
  }
  // Beside a line the point may be rounded into the next cell, of which the chart has no part.
  const Element* nearest = nullptr;
  Point place{};
  double least = -std::numeric_limits<double>::infinity();
  for (const double aside : {0.0, -same_point, same_point})
    for (const double below : {0.0, -same_point, same_point}) {
      const int i = int(std::floor(column + aside)), j = int(std::floor(row + below));
      const auto cell = cells_.find({atlas_.chart[std::size_t(triangle)], j, i});
      if (cell == cells_.end()) continue;
      const Point p{column - i, row - j};
      for (const Element& element : cell->second.elements) {
        const auto& c = element.corners;
        const double inside = std::min({twice_area(c[0], c[1], p), twice_area(c[1], c[2], p), twice_area(c[2], c[0], p)});
        if (inside > least) least = inside, nearest = &element, place = p;
      }
    }
  require(nearest != nullptr, "the point is in no cell of its chart");
  const Elements q(nearest->corners, place);
  std::vector<BasisWeight> sum;
  for (std::size_t k = 0; k < 6; ++k) add(sum, nearest->nodes[k], q.value[k]);
  return sum;
}

}  // namespace mq
