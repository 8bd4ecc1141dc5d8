/// Rows are gathered from the triangles around each vertex rather than scattered from triangles, so
/// that they can be summed in parallel and always in the same order.

#include "mq/fem/vertex_space.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/detail/mixed.h"
#include "mq/fem/vertex_multigrid.h"

namespace mq {

namespace {

/// Mass of a vertex that no area reaches, in means over all vertices.
constexpr double massless = 1e-12;

/// The edges of one triangle of a surface whose fans were joined again, so that it has no twins.
std::vector<int> ends_of_single_edges(const Mesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      if (low != high) edges.push_back({low, high});
    }
  std::sort(edges.begin(), edges.end());
  std::vector<int> vertices;
  for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
    while (end < edges.size() && edges[end] == edges[first]) ++end;
    if (end - first == 1) vertices.insert(vertices.end(), edges[first].begin(), edges[first].end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

std::vector<int> boundary_vertices(const Surface& surface) {
  if (surface.twins.empty()) return ends_of_single_edges(surface.mesh);
  std::vector<int> vertices;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3;
    if (surface.twins[std::size_t(h)] >= 0 || surface.degenerate[t]) continue;
    vertices.push_back(surface.mesh.triangles[t][h % 3]);
    vertices.push_back(surface.mesh.triangles[t][(h + 1) % 3]);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace

VertexSpace::VertexSpace(const Surface& surface) : VertexSpace(surface, flat_triangles(surface)) {}

VertexSpace::VertexSpace(const Surface& surface, std::vector<FlatTriangle> shapes)
    : triangles_(surface.mesh.triangles),
      positions_(surface.mesh.positions),
      boundary_(boundary_vertices(surface)),
      shapes_(std::move(shapes)) {
  require(shapes_.size() == triangles_.size(),
          fmt::format("{} shapes were given for {} triangles", shapes_.size(), triangles_.size()));
  incident_begin_.assign(surface.mesh.vertex_count() + 1, 0);
  area_ = parallel_sum(triangle_count(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t t = begin; t < end; ++t) sum += shapes_[t].area();
    return sum;
  });
  require(area_ > 0, "the surface has no area: it has no triangles, or all are degenerate");
  find_incident_corners();
  find_pattern();
}

void VertexSpace::find_incident_corners() {
  std::vector<int>& begin = incident_begin_;
  for (int t = 0; t < triangle_count(); ++t)
    if (!shapes_[t].empty())
      for (const int v : triangles_[t]) ++begin[v + 1];
  for (int v = 0; v < size(); ++v) begin[v + 1] += begin[v];
  incident_.resize(begin.back());
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (int t = 0; t < triangle_count(); ++t)
    if (!shapes_[t].empty())
      for (int k = 0; k < 3; ++k) incident_[next[triangles_[t][k]]++] = 3 * t + k;
}

void VertexSpace::find_pattern() {
  const auto neighbours = [&](int v, std::vector<int>& row) {
    row.assign(1, v);
    for (int n = incident_begin_[v]; n < incident_begin_[v + 1]; ++n)
      for (const int other : triangles_[incident_[n] / 3]) row.push_back(other);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  };
  row_begin_.assign(size() + 1, 0);
  parallel_blocks(size(), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int> row;
    for (std::int64_t v = begin; v < end; ++v) {
      neighbours(int(v), row);
      row_begin_[v + 1] = int(row.size());
    }
  });
  for (int v = 0; v < size(); ++v) row_begin_[v + 1] += row_begin_[v];
  column_.resize(row_begin_.back());
  parallel_blocks(size(), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int> row;
    for (std::int64_t v = begin; v < end; ++v) {
      neighbours(int(v), row);
      std::copy(row.begin(), row.end(), column_.begin() + row_begin_[v]);
    }
  });
}

/// a·M + Σ_t factor(t)·S_t.
template <class Factor>
SparseMatrix VertexSpace::assemble(double a, const Factor& factor, const Progress& progress) const {
  SparseMatrix A(size(), size());
  A.resizeNonZeros(Eigen::Index(column_.size()));
  std::copy(row_begin_.begin(), row_begin_.end(), A.outerIndexPtr());
  std::copy(column_.begin(), column_.end(), A.innerIndexPtr());
  progress.check();
  parallel_for(size(), [&](std::int64_t i) {
    const int* columns = column_.data() + row_begin_[i];
    const int count = row_begin_[i + 1] - row_begin_[i];
    double* values = A.valuePtr() + row_begin_[i];
    std::fill(values, values + count, 0.0);
    const auto entry = [&](int j) -> double& {
      return values[std::lower_bound(columns, columns + count, j) - columns];
    };
    double& diagonal = entry(int(i));
    for (int n = incident_begin_[i]; n < incident_begin_[i + 1]; ++n) {
      const int t = incident_[n] / 3, k = incident_[n] % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      const double mass = a * shapes_[t].area() / 12;
      const double b = factor(t);
      const double s1 = b * shapes_[t].half_cotangent(k2), s2 = b * shapes_[t].half_cotangent(k1);
      diagonal += 2 * mass + (s1 + s2);
      entry(triangles_[t][k1]) += mass - s1;
      entry(triangles_[t][k2]) += mass - s2;
    }
    if (incident_begin_[i] == incident_begin_[i + 1]) diagonal = a * massless * area_ / size();
  });
  progress.at(1);
  return A;
}

SparseMatrix VertexSpace::system(double a, double b, const Progress& progress) const {
  return assemble(
      a, [&](int) { return b; }, progress);
}

SparseMatrix VertexSpace::weighted_system(double a, double b, std::span<const float> conductivity,
                                          const Progress& progress) const {
  require(std::ssize(conductivity) == triangle_count(), "one conductivity per triangle is needed");
  return assemble(
      a, [&](int t) { return b * conductivity[t]; }, progress);
}

Vector VertexSpace::lumped_mass() const {
  Vector mass(size());
  parallel_for(size(), [&](std::int64_t i) {
    double area = 0;
    for (int n = incident_begin_[i]; n < incident_begin_[i + 1]; ++n)
      area += shapes_[incident_[n] / 3].area();
    mass[i] = incident_begin_[i] == incident_begin_[i + 1] ? massless * area_ / size() : area / 3;
  });
  return mass;
}

/// Σ_t factor(t)·S_t·ψ, in some rows or in all.
template <class Factor>
Signal VertexSpace::stiffness_product(std::span<const int> rows, const Signal& psi,
                                      const Factor& factor) const {
  const std::int64_t count = rows.empty() ? size() : std::ssize(rows);
  Signal result(count, psi.cols());
  parallel_for(count, [&](std::int64_t at) {
    const std::int64_t i = rows.empty() ? at : rows[std::size_t(at)];
    auto sum = result.row(at);
    sum.setZero();
    for (int n = incident_begin_[i]; n < incident_begin_[i + 1]; ++n) {
      const int t = incident_[n] / 3, k = incident_[n] % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      const Triangle& v = triangles_[t];
      const double mean = factor(t);
      const double s1 = mean * shapes_[t].half_cotangent(k2);
      const double s2 = mean * shapes_[t].half_cotangent(k1);
      sum += s1 * (psi.row(i) - psi.row(v[k1])) + s2 * (psi.row(i) - psi.row(v[k2]));
    }
  });
  return result;
}

Signal VertexSpace::stiffness_times(const Signal& psi, std::span<const double> beta) const {
  return stiffness_rows({}, psi, beta);
}

Signal VertexSpace::stiffness_rows(std::span<const int> rows, const Signal& psi,
                                   std::span<const double> beta) const {
  require(
      psi.rows() == size() && (beta.empty() || int(beta.size()) == size()),
      fmt::format("a signal of {} rows and a modulation of {} values were given for {} vertices",
                  psi.rows(), beta.size(), size()));
  return stiffness_product(rows, psi, [&](int t) {
    const Triangle& v = triangles_[t];
    return beta.empty() ? 1 : (beta[v[0]] + beta[v[1]] + beta[v[2]]) / 3;
  });
}

Signal VertexSpace::weighted_stiffness_times(const Signal& psi,
                                             std::span<const float> conductivity) const {
  require(psi.rows() == size() && std::ssize(conductivity) == triangle_count(),
          "one row per vertex and one conductivity per triangle are needed");
  return stiffness_product({}, psi, [&](int t) { return double(conductivity[t]); });
}

/// On a triangle ∫ φ_i ⟨∇φ_j, ∇φ_t⟩ dA = ⅓ S_jt, as gradients are constant there.
Signal VertexSpace::edge_divergence(const std::vector<std::array<int, 2>>& edges, const Signal& z) const {
  require(z.rows() == std::ssize(edges), "one row per edge is needed");
  const auto add = [&](int from, int to, double factor, auto&& sum) {
    const std::array<int, 2> pair{std::min(from, to), std::max(from, to)};
    const auto at = std::lower_bound(edges.begin(), edges.end(), pair);
    if (at != edges.end() && *at == pair) sum += (from < to ? factor : -factor) * z.row(at - edges.begin());
  };
  Signal result = Signal::Zero(size(), z.cols());
  parallel_for(size(), [&](std::int64_t i) {
    for (int n = incident_begin_[i]; n < incident_begin_[i + 1]; ++n) {
      const int t = incident_[n] / 3, k = incident_[n] % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      const Triangle& v = triangles_[t];
      const double s1 = shapes_[t].half_cotangent(k2) / 3, s2 = shapes_[t].half_cotangent(k1) / 3;
      const double own = s1 + s2;  // S_ii, S_i1 = −s1 and S_i2 = −s2, a third of them
      add(v[k], v[k1], -s1 - own, result.row(i));
      add(v[k], v[k2], -s2 - own, result.row(i));
      add(v[k1], v[k2], -s2 + s1, result.row(i));
    }
  });
  return result;
}

std::vector<float> VertexSpace::gradient_norms(const Signal& psi) const {
  const Signal field = gradient(psi);
  std::vector<float> norms(triangles_.size());
  parallel_for(triangle_count(), [&](std::int64_t t) {
    norms[t] = float(std::hypot(field.row(2 * t).norm(), field.row(2 * t + 1).norm()));
  });
  return norms;
}

Signal VertexSpace::gradient(const Signal& phi) const {
  require(phi.rows() == size(),
          fmt::format("a signal of {} rows was given for {} vertices", phi.rows(), size()));
  Signal field = Signal::Zero(2 * triangle_count(), phi.cols());
  parallel_for(triangle_count(), [&](std::int64_t t) {
    if (shapes_[t].empty()) return;
    const Triangle& v = triangles_[t];
    const Vector2 g1 = shapes_[t].gradient(1), g2 = shapes_[t].gradient(2);
    for (int i = 0; i < 2; ++i)
      field.row(2 * t + i) =
          g1[i] * (phi.row(v[1]) - phi.row(v[0])) + g2[i] * (phi.row(v[2]) - phi.row(v[0]));
  });
  return field;
}

Signal VertexSpace::gradient_moments(const Signal& field) const {
  require(field.rows() == 2 * triangle_count(),
          fmt::format("a field of {} rows was given for {} triangles, which have two each",
                      field.rows(), triangle_count()));
  Signal moments = Signal::Zero(size(), field.cols());
  parallel_for(size(), [&](std::int64_t i) {
    for (int n = incident_begin_[i]; n < incident_begin_[i + 1]; ++n) {
      const int t = incident_[n] / 3, k = incident_[n] % 3;
      const Vector2 g = shapes_[t].area() * shapes_[t].gradient(k);
      moments.row(i) += g.x() * field.row(2 * t) + g.y() * field.row(2 * t + 1);
    }
  });
  return moments;
}

SparseMatrix VertexSpace::gradient_matrix() const {
  Entries entries;
  entries.reserve(6 * triangles_.size());
  for (int t = 0; t < triangle_count(); ++t) {
    if (shapes_[t].empty()) continue;
    for (int k = 0; k < 3; ++k) {
      const Vector2 g = shapes_[t].gradient(k);
      entries.emplace_back(2 * t, triangles_[t][k], g.x());
      entries.emplace_back(2 * t + 1, triangles_[t][k], g.y());
    }
  }
  return sparse_matrix(2 * triangle_count(), size(), entries);
}

std::vector<BasisWeight> VertexSpace::basis_at(int triangle, const Vector3& barycentric) const {
  require(triangle >= 0 && triangle < triangle_count(),
          fmt::format("triangle {} is none of {}", triangle, triangle_count()));
  std::vector<BasisWeight> weights;
  for (int k = 0; k < 3; ++k)
    if (barycentric[k] != 0) weights.push_back({triangles_[triangle][k], barycentric[k]});
  return weights;
}

double VertexSpace::largest_shown(const Vector& values) const {
  require(values.size() == size(), "one value per vertex is needed");
  double largest = 0;
  for (const double value : values)
    if (std::isfinite(value)) largest = std::max(largest, value);
  return largest;
}

SolverFactory VertexSpace::multigrid(const StoppingRule& stop) const {
  return vertex_multigrid_solver(positions_, stopping<MultigridOptions>(stop));
}

void VertexSpace::for_each_mixed_element(std::span<const int> labels,
                                         const std::function<void(const Element&)>& visit) const {
  require(std::ssize(labels) == size(), "one label per vertex is needed");
  for (int t = 0; t < triangle_count(); ++t) {
    const Triangle& own = triangles_[t];
    const FlatTriangle& shape = shapes_[t];
    if (shape.empty() || !mixed(own, labels)) continue;
    std::array<double, 9> S{};
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const double s = shape.half_cotangent(k);
      S[3 * i + j] = S[3 * j + i] = -s;
      S[4 * i] += s, S[4 * j] += s;
    }
    visit({own, own, S});
  }
}

}  // namespace mq
