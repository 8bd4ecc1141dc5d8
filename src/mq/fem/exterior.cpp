/// S₁ = d₁ᵀ⋆₂d₁ + ⋆₁d₀⋆₀⁻¹d₀ᵀ⋆₁.
///
/// d₀ and d₁ are pure topology, the stars pure metric. Unlike the thesis, d₀ is target minus source,
/// so that ω = d₀φ integrates ∇φ along the edge; ⋆₀ stays positive on obtuse triangles.

#include "mq/fem/exterior.h"

#include <array>

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

SparseMatrix vertex_area_mass(const Vector& star_zero) {
  Vector twice(2 * star_zero.size());
  for (Eigen::Index i = 0; i < star_zero.size(); ++i)
    twice.segment<2>(2 * i).setConstant(star_zero[i] > 0 ? star_zero[i] : 1.0);
  return diagonal_matrix(twice);
}

}  // namespace mq
