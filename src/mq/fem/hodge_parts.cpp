/// The hat function of edge e is ψ_e = 1 − 2φ_k in both its triangles, k the corner opposite: 1 along e, −1 in that
/// corner. So ∇ψ_e = −2∇φ_k, and the matrix of v has four times the cotangents of that of u.

#include "mq/fem/hodge_parts.h"

#include <array>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

/// LinearFunctions linear in triangles, three of which are not constant in each.
struct LinearFunctions {
  int count = 0;
  double slope = 1;                        ///< their gradients, as a multiple of ∇φ of the corner
  std::vector<std::array<int, 3>> numbers; ///< per triangle the function of each corner; −1: held at 0
};

/// S and b of S·f = b, b_i = ∫ ⟨Y, ∇f_i⟩, one function of each component held at 0 where none is.
struct WeakPoisson {
  SparseMatrix S;
  Vector b;
};

WeakPoisson weak_poisson(const LinearFunctions& functions, const std::vector<FlatTriangle>& shapes, const Vector& field) {
  Entries entries;
  WeakPoisson result{{}, Vector::Zero(functions.count)};
  for (std::size_t t = 0; t < shapes.size(); ++t) {
    if (shapes[t].empty()) continue;
    const double area = shapes[t].area();
    for (int k = 0; k < 3; ++k) {
      const int i = functions.numbers[t][k];
      if (i < 0) continue;
      const Vector2 gradient = functions.slope * shapes[t].gradient(k);
      result.b[i] += area * gradient.dot(field.segment<2>(2 * Eigen::Index(t)));
      for (int l = 0; l < 3; ++l)
        if (const int j = functions.numbers[t][l]; j >= 0)
          entries.emplace_back(i, j, area * gradient.dot(functions.slope * shapes[t].gradient(l)));
    }
  }
  result.S = sparse_matrix(functions.count, functions.count, entries);
  return result;
}

/// f with S·f = b, where S is singular by constants on some components; 0 where nothing reaches.
Vector pinned_solution(WeakPoisson system, const std::vector<char>& beside_held, const Progress& progress) {
  const int count = int(system.S.rows());
  const std::vector<int> component = connected_components(system.S, Joining::pattern);
  std::vector<char> held(component.size(), 0);
  for (int i = 0; i < count; ++i)
    if (beside_held[std::size_t(i)]) held[std::size_t(component[std::size_t(i)])] = 1;
  Entries pins;
  for (int i = 0; i < count; ++i)
    if (char& done = held[std::size_t(component[std::size_t(i)])]; !done) {
      done = 1;
      const double diagonal = system.S.coeff(i, i);
      pins.emplace_back(i, i, diagonal > 0 ? diagonal : 1);
    }
  system.S += sparse_matrix(count, count, pins);
  return DirectSolver(system.S, Factorisation::automatic, progress).solve(system.b, progress);
}

/// ∇f per triangle, in its frame.
Vector gradients_of(const LinearFunctions& functions, const std::vector<FlatTriangle>& shapes, const Vector& f) {
  Vector result = Vector::Zero(2 * std::ssize(shapes));
  for (std::size_t t = 0; t < shapes.size(); ++t)
    for (int k = 0; k < 3 && !shapes[t].empty(); ++k)
      if (const int i = functions.numbers[t][k]; i >= 0)
        result.segment<2>(2 * Eigen::Index(t)) += f[i] * functions.slope * shapes[t].gradient(k);
  return result;
}

/// The field turned by `quarters` times 90° counter-clockwise, 1 or −1.
Vector quarter_turns(const Vector& field, double quarters) {
  Vector result(field.size());
  for (Eigen::Index t = 0; t < field.size(); t += 2)
    result.segment<2>(t) = quarters * turned(Vector2(field.segment<2>(t)));
  return result;
}

/// Of mean 0 on each component.
void remove_means(Vector& f, const std::vector<int>& component, const std::vector<char>& fixed) {
  std::vector<double> sum(component.size(), 0), count(component.size(), 0);
  for (Eigen::Index i = 0; i < f.size(); ++i)
    sum[std::size_t(component[std::size_t(i)])] += f[i], count[std::size_t(component[std::size_t(i)])] += 1;
  for (Eigen::Index i = 0; i < f.size(); ++i)
    if (const auto c = std::size_t(component[std::size_t(i)]); !fixed[c]) f[i] -= sum[c] / count[c];
}

/// LinearFunctions of vertices, continuous.
LinearFunctions of_vertices(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  LinearFunctions functions{.count = surface.mesh.vertex_count(), .numbers = surface.mesh.triangles};
  for (std::size_t t = 0; t < shapes.size(); ++t)
    if (shapes[t].empty()) functions.numbers[t] = {-1, -1, -1};
  return functions;
}

/// LinearFunctions of edges, 0 along boundaries.
LinearFunctions of_edges(const Edges& edges, const std::vector<char>& boundary, std::size_t triangles) {
  LinearFunctions functions{.count = edges.count(), .slope = -2, .numbers = {}};
  functions.numbers.resize(triangles, {-1, -1, -1});
  for (std::size_t h = 0; h < edges.from_half_edge.size(); ++h)
    if (const int e = edges.from_half_edge[h]; e >= 0 && !boundary[std::size_t(e)])
      functions.numbers[h / 3][(h + 2) % 3] = e;
  return functions;
}

}  // namespace

HodgeParts hodge_parts(const Surface& surface, const TangentField& field, const Progress& progress) {
  require(std::ssize(field) == surface.triangle_count(),
          fmt::format("a field of {} vectors was given for {} triangles", field.size(), surface.triangle_count()));
  for (std::size_t t = 0; t < field.size(); ++t)
    if (!field[t].allFinite()) throw InvalidInput(fmt::format("the vector of triangle {} is not finite", t));
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  const Vector X = field_in_frames(surface, field);
  HodgeParts parts;
  parts.edges = make_edges(surface, shapes);

  const LinearFunctions hats = of_vertices(surface, shapes);
  WeakPoisson divergence = weak_poisson(hats, shapes, X);
  const std::vector<int> pieces = connected_components(divergence.S, Joining::pattern);
  parts.potential = pinned_solution(std::move(divergence), std::vector<char>(std::size_t(hats.count), 0),
                           progress.step("potential", 0.3));
  remove_means(parts.potential, pieces, std::vector<char>(pieces.size(), 0));
  const Vector gradient = gradients_of(hats, shapes, parts.potential);

  std::vector<char> boundary(std::size_t(parts.edges.count()), 1), beside(boundary.size(), 0);
  std::vector<int> sides(boundary.size(), 0);
  for (const int e : parts.edges.from_half_edge)
    if (e >= 0 && ++sides[std::size_t(e)] == 2) boundary[std::size_t(e)] = 0;
  for (std::size_t h = 0; h < parts.edges.from_half_edge.size(); ++h)
    if (const int e = parts.edges.from_half_edge[h]; e >= 0 && boundary[std::size_t(e)])
      for (std::size_t k = 0; k < 3; ++k)
        if (const int other = parts.edges.from_half_edge[h / 3 * 3 + k]; other >= 0 && !boundary[std::size_t(other)])
          beside[std::size_t(other)] = 1;
  // ⟨X, J∇ψ⟩ = ⟨−JX, ∇ψ⟩.
  const LinearFunctions middles = of_edges(parts.edges, boundary, shapes.size());
  WeakPoisson rotation = weak_poisson(middles, shapes, quarter_turns(X, -1));
  const std::vector<int> rings = connected_components(rotation.S, Joining::pattern);
  std::vector<char> fixed(rings.size(), 0);
  for (std::size_t e = 0; e < rings.size(); ++e)
    if (boundary[e] || beside[e]) fixed[std::size_t(rings[e])] = 1;
  parts.stream = pinned_solution(std::move(rotation), beside, progress.step("stream function", 0.7));
  remove_means(parts.stream, rings, fixed);
  const Vector curl = quarter_turns(gradients_of(middles, shapes, parts.stream), 1);

  parts.gradient = field_in_space(surface, gradient);
  parts.curl = field_in_space(surface, curl);
  parts.harmonic = field_in_space(surface, X - gradient - curl);
  return parts;
}

Vector stream_at_vertices(const Surface& surface, const HodgeParts& parts) {
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  Vector sum = Vector::Zero(surface.mesh.vertex_count()), area = sum;
  for (std::size_t h = 0; h < parts.edges.from_half_edge.size(); ++h) {
    const int e = parts.edges.from_half_edge[h];
    if (e < 0) continue;
    for (const std::size_t k : {h % 3, (h + 1) % 3}) {
      const int v = surface.mesh.triangles[h / 3][k];
      sum[v] += shapes[h / 3].area() * parts.stream[e];
      area[v] += shapes[h / 3].area();
    }
  }
  return (area.array() > 0).select(sum.array() / area.array().max(1e-300), 0).matrix();
}

}  // namespace mq
