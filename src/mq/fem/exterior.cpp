/// S₁ = d₁ᵀ⋆₂d₁ + ⋆₁d₀⋆₀⁻¹d₀ᵀ⋆₁.
///
/// d₀ and d₁ are pure topology, the stars pure metric. Unlike the thesis, d₀ is target minus source,
/// so that ω = d₀φ integrates ∇φ along the edge; ⋆₀ stays positive on obtuse triangles.

#include "mq/fem/exterior.h"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

namespace {

/// What each corner gets of the triangle's area.
std::array<double, 3> corner_areas(const FlatTriangle& shape, VertexArea kind) {
  const double area = shape.area();
  if (kind == VertexArea::barycentric) return {area / 3, area / 3, area / 3};
  for (int k = 0; k < 3; ++k)
    if (shape.half_cotangent(k) <= 0) {
      std::array<double, 3> areas{area / 4, area / 4, area / 4};
      areas[k] = area / 2;
      return areas;
    }
  std::array<double, 3> areas{};
  for (int k = 0; k < 3; ++k) {  // the kites on both sides of edge k
    const double kite = shape.edge(k).squaredNorm() * shape.half_cotangent((k + 2) % 3) / 4;
    areas[k] += kite;
    areas[(k + 1) % 3] += kite;
  }
  return areas;
}

double corner_angle(const FlatTriangle& shape, int k) {
  return std::atan2(0.5, shape.half_cotangent(k));
}

/// Directions of edges around vertices.
struct Directions {
  std::vector<double> at_source;  ///< per half-edge the angle of the edge at its source
  std::vector<double> at_target;  ///< and at its target, looking back
};

/// Walks around vertices.
class Fans {
 public:
  Fans(const Surface& surface, const std::vector<FlatTriangle>& shapes)
      : surface_(surface), shapes_(shapes),
        visited_(shapes.size() * 3, 0), total_(surface.mesh.vertex_count(), 0.0),
        closed_(surface.mesh.vertex_count(), 0) {}

  Directions directions() {
    Directions d{std::vector<double>(visited_.size(), 0.0), std::vector<double>(visited_.size(), 0.0)};
    for (HalfEdge h = 0; h < HalfEdge(visited_.size()); ++h)
      if (!visited_[h] && !shapes_[h / 3].empty()) walk(first_of_fan(h), d);
    for (HalfEdge h = 0; h < HalfEdge(visited_.size()); ++h) scale(h, d);
    return d;
  }

 private:
  int source(HalfEdge h) const { return surface_.mesh.triangles[h / 3][h % 3]; }

  HalfEdge twin(HalfEdge h) const {
    const HalfEdge t = surface_.twins[h];
    return t >= 0 && !shapes_[t / 3].empty() ? t : -1;
  }

  /// Clockwise until the boundary, or once around.
  HalfEdge first_of_fan(HalfEdge start) const {
    HalfEdge h = start;
    while (twin(h) >= 0) {
      h = next(twin(h));
      if (h == start) break;
    }
    return h;
  }

  /// Counter-clockwise from the fan's first half-edge, adding up angles.
  void walk(HalfEdge first, Directions& d) {
    const int vertex = source(first);
    double& angle = total_[vertex];
    HalfEdge h = first;
    while (true) {
      visited_[h] = 1;
      d.at_source[h] = angle;
      if (twin(h) >= 0) d.at_target[twin(h)] = angle;
      angle += corner_angle(shapes_[h / 3], h % 3);
      const HalfEdge across = twin(previous(h));
      if (across < 0) {
        d.at_target[previous(h)] = angle;
        return;
      }
      h = across;
      if (h == first) break;
    }
    closed_[vertex] = 1;
  }

  /// Around inner vertices angles are made to sum to 2π.
  void scale(HalfEdge h, Directions& d) const {
    const int from = source(h), to = source(next(h));
    if (closed_[from]) d.at_source[h] *= 2 * std::numbers::pi / total_[from];
    if (closed_[to]) d.at_target[h] *= 2 * std::numbers::pi / total_[to];
  }

  const Surface& surface_;
  const std::vector<FlatTriangle>& shapes_;
  std::vector<char> visited_;
  std::vector<double> total_;
  std::vector<char> closed_;
};

/// Adds w·|z_i − r·z_j|², r the rotation by `angle`.
void add_coupling(Entries& entries, int i, int j, double w, double angle) {
  const double c = w * std::cos(angle), s = w * std::sin(angle);
  for (int k = 0; k < 2; ++k) {
    entries.emplace_back(2 * i + k, 2 * i + k, w);
    entries.emplace_back(2 * j + k, 2 * j + k, w);
    entries.emplace_back(2 * i + k, 2 * j + k, -c);
    entries.emplace_back(2 * j + k, 2 * i + k, -c);
  }
  entries.emplace_back(2 * i, 2 * j + 1, s);
  entries.emplace_back(2 * j + 1, 2 * i, s);
  entries.emplace_back(2 * i + 1, 2 * j, -s);
  entries.emplace_back(2 * j, 2 * i + 1, -s);
}

}  // namespace

SparseMatrix diagonal_matrix(const Vector& diagonal) {
  SparseMatrix D(diagonal.size(), diagonal.size());
  D.reserve(Eigen::VectorXi::Ones(diagonal.size()));
  for (int i = 0; i < diagonal.size(); ++i) D.insert(i, i) = diagonal[i];
  D.makeCompressed();
  return D;
}

SparseMatrix d0(const Edges& edges, int vertex_count) {
  Entries entries;
  for (int e = 0; e < edges.count(); ++e) {
    entries.emplace_back(e, edges.vertices[e][0], -1);
    entries.emplace_back(e, edges.vertices[e][1], 1);
  }
  return sparse_matrix(edges.count(), vertex_count, entries);
}

SparseMatrix d1(const Edges& edges) {
  Entries entries;
  const int half_edges = int(edges.from_half_edge.size());
  for (HalfEdge h = 0; h < half_edges; ++h)
    if (edges.from_half_edge[h] >= 0)
      entries.emplace_back(h / 3, edges.from_half_edge[h], edges.sign[h]);
  return sparse_matrix(half_edges / 3, edges.count(), entries);
}

HodgeStars hodge_stars(const Edges& edges, const std::vector<Triangle>& triangles,
                       const std::vector<FlatTriangle>& shapes, int vertex_count,
                       VertexArea area) {
  HodgeStars stars{Vector::Zero(vertex_count), Vector::Zero(edges.count()),
                   Vector::Zero(Eigen::Index(triangles.size()))};
  for (int t = 0; t < int(triangles.size()); ++t) {
    if (shapes[t].empty()) continue;
    const std::array<double, 3> areas = corner_areas(shapes[t], area);
    for (int k = 0; k < 3; ++k) {
      stars.zero[triangles[t][k]] += areas[k];
      stars.one[edges.from_half_edge[3 * t + k]] += shapes[t].half_cotangent((k + 2) % 3);
    }
    stars.two[t] = 1 / shapes[t].area();
  }
  return stars;
}

SparseMatrix hodge_laplacian(const Edges& edges, const HodgeStars& stars,
                             const SparseMatrix& star_one) {
  require(star_one.rows() == edges.count() && star_one.cols() == edges.count(),
          fmt::format("a star of {} rows was given for {} edges", star_one.rows(), edges.count()));
  const SparseMatrix curl = d1(edges);
  const SparseMatrix divergence = d0(edges, int(stars.zero.size())).transpose() * star_one;
  const Vector inverse =
      stars.zero.unaryExpr([](double area) { return area > 0 ? 1 / area : 0.0; });
  const SparseMatrix weighted_curl = stars.two.asDiagonal() * curl;
  const SparseMatrix weighted_divergence = inverse.asDiagonal() * divergence;
  return SparseMatrix(curl.transpose() * weighted_curl) +
         SparseMatrix(divergence.transpose() * weighted_divergence);
}

SparseMatrix connection_laplacian(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  require(int(shapes.size()) == surface.triangle_count(),
          fmt::format("{} shapes were given for {} triangles", shapes.size(),
                      surface.triangle_count()));
  const Directions directions = Fans(surface, shapes).directions();
  Entries entries;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && !shapes[t].empty(); ++k) {
      const HalfEdge h = 3 * t + k;
      const Triangle& v = surface.mesh.triangles[t];
      const double turn = directions.at_source[h] - directions.at_target[h] - std::numbers::pi;
      add_coupling(entries, v[k], v[(k + 1) % 3], shapes[t].half_cotangent((k + 2) % 3), turn);
    }
  const int size = 2 * surface.mesh.vertex_count();
  return sparse_matrix(size, size, entries);
}

SparseMatrix vertex_area_mass(const Vector& star_zero) {
  Vector twice(2 * star_zero.size());
  for (Eigen::Index i = 0; i < star_zero.size(); ++i)
    twice.segment<2>(2 * i).setConstant(star_zero[i] > 0 ? star_zero[i] : 1.0);
  return diagonal_matrix(twice);
}

}  // namespace mq
