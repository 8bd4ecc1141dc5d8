// For a triangle with rest shape P (isometric in the plane) and gradients G of its hat functions,
// the map x has the Jacobian J = Σ xᵢ Gᵢᵀ = U diag(σ) Vᵀ, the energy is
//
//   E = Σ A (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²),   ∂E/∂J = A U diag(2σ − 2σ⁻³) Vᵀ,
//
// and the quadratic model of a step has the matrix 2 A M ⊗ G Gᵀ with M = U diag(w) Uᵀ,
// w = (2σ − 2σ⁻³) / (2(σ − 1)) = σ⁻³ (σ + 1)(σ² + 1) > 0. The right side is the true gradient, so
// a step never ascends.

#include "mq/sample/detail/flatten.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/dense.h"
#include "mq/linear/direct.h"
#include "mq/mesh/first_flat.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/tutte.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

using Matrix2 = Eigen::Matrix2d;
using Points = std::vector<Vector2>;

/// Samples are the same bits in every build.
constexpr Factorisation everywhere_the_same = Factorisation::eigen;

/// One chart on its way to the plane, with vertices of its own.
struct Disc {
  std::vector<int> ids;             // of the vertices, in the pool of all charts
  std::vector<Triangle> triangles;  // of local vertices
  std::vector<int> loop;            // boundary vertices, counter-clockwise
  std::vector<double> areas;
  std::vector<Eigen::Matrix<double, 3, 2>> gradients;  // of the hat functions in the rest shape
  Points x;
};

// ---- Charts as discs ----

/// The third corner of the triangle laid out with its first at 0 and its second on the x-axis.
void rest_shape(const Mesh& mesh, int t, Disc& disc) {
  const Vector3 a = mesh.position(t, 1) - mesh.position(t, 0);
  const Vector3 b = mesh.position(t, 2) - mesh.position(t, 0);
  const double length = a.norm(), area = a.cross(b).norm() / 2;
  if (!(area > 0))
    throw InvalidInput(fmt::format("triangle {} has no area and cannot be flattened", t));
  Matrix2 edges;  // columns: images of b - a corner
  edges << length, a.dot(b) / length, 0, 2 * area / length;
  const Matrix2 inverse = edges.inverse();  // rows: gradients of the second and third hat function
  Eigen::Matrix<double, 3, 2> gradients;
  gradients.row(1) = inverse.row(0);
  gradients.row(2) = inverse.row(1);
  gradients.row(0) = -inverse.row(0) - inverse.row(1);
  disc.areas.push_back(area);
  disc.gradients.push_back(gradients);
}

/// Chart by chart the boundary loop, from the half-edges that have no partner in the chart.
void find_loop(const std::vector<std::array<int, 2>>& edges, int chart, Disc& disc) {
  std::vector<int> after(disc.ids.size(), -1);
  for (const auto& [from, to] : edges) {
    if (after[from] >= 0) throw InvalidInput(fmt::format("chart {} touches itself", chart));
    after[from] = to;
  }
  int inner = 0;
  for (const int a : after) inner += a < 0;
  if (!edges.empty()) {
    int v = edges.front()[0];
    do {
      disc.loop.push_back(v);
      v = after[v];
    } while (v >= 0 && v != edges.front()[0]);
  }
  // A disc has V - E + T = 1 with 2 E = 3 T + B.
  const auto triangles = std::ssize(disc.triangles), boundary = std::ssize(edges);
  if (std::ssize(disc.loop) != boundary || boundary == 0 ||
      2 * std::ssize(disc.ids) - (3 * triangles + boundary) + 2 * triangles != 2)
    throw InvalidInput(
        fmt::format("chart {} is not a disc: it has {} triangles, {} boundary edges "
                    "and {} inner vertices",
                    chart, triangles, boundary, inner));
}

std::vector<Disc> cut(const Surface& surface, const std::vector<char>& seams, FlatCharts& flat) {
  const auto half_edges = HalfEdge(surface.twins.size());
  DisjointSets corners(surface.twins.size()), triangles(surface.mesh.triangles.size());
  const auto inside = [&](HalfEdge h) { return surface.twins[h] >= 0 && !seams[h]; };
  for (HalfEdge h = 0; h < half_edges; ++h)
    if (inside(h)) {
      corners.join(h, next(surface.twins[h]));
      triangles.join(h / 3, surface.twins[h] / 3);
    }
  flat.charts.resize(surface.mesh.triangles.size());
  flat.corner_uvs.resize(surface.mesh.triangles.size());
  std::vector<int> local(surface.twins.size());  // of a corner's root, its vertex in its chart
  std::vector<int> pool(surface.twins.size());
  std::vector<Disc> discs;
  std::vector<std::vector<std::array<int, 2>>> boundaries;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const int root = triangles.root(t);
    if (root == t) {
      flat.charts[t] = flat.count++;
      discs.emplace_back();
      boundaries.emplace_back();
    }
    const int chart = flat.charts[t] = flat.charts[root];
    Disc& disc = discs[chart];
    disc.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const int corner = corners.root(3 * t + k);
      if (corner == 3 * t + k) {
        local[corner] = int(disc.ids.size());
        pool[corner] = int(flat.uvs.size());
        disc.ids.push_back(pool[corner]);
        flat.uvs.emplace_back();
      }
      disc.triangles.back()[k] = local[corner];
      flat.corner_uvs[t][k] = pool[corner];
    }
    rest_shape(surface.mesh, t, disc);
  }
  for (HalfEdge h = 0; h < half_edges; ++h)
    if (!inside(h))
      boundaries[flat.charts[h / 3]].push_back(
          {local[corners.root(h)], local[corners.root(next(h))]});
  for (int c = 0; c < flat.count; ++c) find_loop(boundaries[c], c, discs[c]);
  return discs;
}

void embed_on_circle(Disc& disc) {
  double area = 0;
  for (const double a : disc.areas) area += a;
  disc.x =
      tutte_embedding(int(disc.ids.size()), disc.triangles, disc.loop, area, everywhere_the_same);
}

// ---- Lowering the energy ----

Matrix2 jacobian(const Disc& disc, std::size_t t, const Points& x) {
  const Triangle& v = disc.triangles[t];
  Matrix2 J = Matrix2::Zero();
  for (int k = 0; k < 3; ++k) J += x[v[k]] * disc.gradients[t].row(k);
  return J;
}

/// Infinite where a triangle is flipped or flat.
double energy(const Disc& disc, const Points& x) {
  double sum = 0;
  for (std::size_t t = 0; t < disc.triangles.size(); ++t) {
    const Matrix2 J = jacobian(disc, t, x);
    const double det = J.determinant();
    if (!(det > 0)) return std::numeric_limits<double>::infinity();
    sum += disc.areas[t] * J.squaredNorm() * (1 + 1 / (det * det));  // |J⁻¹|² = |J|² / det²
  }
  return sum;
}

struct Model {
  SparseMatrix matrix;
  Signal gradient;
};

Model quadratic_model(const Disc& disc) {
  const int count = int(disc.ids.size());
  Entries entries;
  entries.reserve(disc.triangles.size() * 36 + 2 * std::size_t(count));
  Model model{{}, Signal::Zero(2 * count, 1)};
  double trace = 0;
  for (std::size_t t = 0; t < disc.triangles.size(); ++t) {
    const SingularValues<2> svd = singular_values(jacobian(disc, t, disc.x));
    const Eigen::Array2d s = svd.values.array().max(1e-8);
    const Vector2 weights = s.cube().inverse() * (s + 1) * (s.square() + 1);
    const Vector2 slopes = 2 * s - 2 * s.cube().inverse();
    const Matrix2 M = svd.U * weights.asDiagonal() * svd.U.transpose();
    const Matrix2 D = svd.U * slopes.asDiagonal() * svd.V.transpose();
    const auto& G = disc.gradients[t];
    const Eigen::Matrix3d K = 2 * disc.areas[t] * G * G.transpose();
    const Eigen::Matrix<double, 3, 2> slope = disc.areas[t] * G * D.transpose();
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 2; ++a) {
        const int row = 2 * disc.triangles[t][i] + a;
        model.gradient(row, 0) += slope(i, a);
        for (int j = 0; j < 3; ++j)
          for (int b = 0; b < 2; ++b)
            entries.emplace_back(row, 2 * disc.triangles[t][j] + b, K(i, j) * M(a, b));
        trace += K(i, i) * M(a, a);
      }
  }
  for (int i = 0; i < 2 * count; ++i)  // translations and rotations cost nothing; fix them softly
    entries.emplace_back(i, i, 1e-7 * trace / (2 * count));
  model.matrix = sparse_matrix(2 * count, 2 * count, entries);
  return model;
}

/// Whether two edges of the boundary cross or touch; neighbours share an end and may not overlap.
bool boundary_crosses(const Disc& disc, const Points& x) {
  struct Edge {
    Vector2 a, b;
    int place;
    double low, high;
  };
  const int count = int(disc.loop.size());
  std::vector<Edge> edges;
  for (int i = 0; i < count; ++i) {
    const Vector2 &a = x[disc.loop[i]], &b = x[disc.loop[(i + 1) % count]];
    edges.push_back({a, b, i, std::min(a.x(), b.x()), std::max(a.x(), b.x())});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& e, const Edge& f) { return e.low < f.low; });
  const auto side = [](const Vector2& p, const Vector2& q, const Vector2& r) {
    const double s = cross(q - p, r - p);
    return (s > 0) - (s < 0);
  };
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = i + 1; j < edges.size() && edges[j].low <= edges[i].high; ++j) {
      const Edge &e = edges[i], &f = edges[j];
      const int apart = std::abs(e.place - f.place);
      if (apart == 1 || apart == count - 1) continue;
      if (side(e.a, e.b, f.a) * side(e.a, e.b, f.b) <= 0 &&
          side(f.a, f.b, e.a) * side(f.a, f.b, e.b) <= 0)
        return true;
    }
  return false;
}

/// Whether a chart may cross itself on its way.
enum class Crossing { allowed, refused };

/// One step; the relative decrease of the energy, 0 if there is no step that lowers it.
double lower(Disc& disc, std::optional<DirectSolver>& solver, Crossing crossing) {
  const double before = energy(disc, disc.x);
  const Model model = quadratic_model(disc);
  if (solver)
    solver->refactor(model.matrix);
  else
    solver.emplace(model.matrix, everywhere_the_same);
  const Signal step = solver->solve(-model.gradient);
  Points direction(disc.x.size());
  for (std::size_t v = 0; v < direction.size(); ++v)
    direction[v] = {step(2 * Eigen::Index(v), 0), step(2 * Eigen::Index(v) + 1, 0)};
  const double slope = (step.transpose() * model.gradient)(0, 0);
  double length = std::min(1.0, 0.8 * first_flat(disc.triangles, disc.x, direction));
  for (int halvings = 0; halvings < 30; ++halvings, length /= 2) {
    Points x = disc.x;
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += length * direction[v];
    const double after = energy(disc, x);
    if (!(after <= before + 1e-4 * length * slope)) continue;
    if (crossing == Crossing::refused && boundary_crosses(disc, x)) continue;
    disc.x = std::move(x);
    return (before - after) / before;
  }
  return 0;
}

void lower_all(Disc& disc, const FlattenOptions& options, Crossing crossing) {
  std::optional<DirectSolver> solver;
  // A single triangle about to flip can hold up a step, but not many in a row.
  for (int i = 0, idle = 0; i < options.iterations && idle < 5; ++i)
    idle = lower(disc, solver, crossing) < options.tolerance ? idle + 1 : 0;
}

void flatten_disc(Disc& disc, const FlattenOptions& options) {
  embed_on_circle(disc);
  if (!std::isfinite(energy(disc, disc.x)))
    throw InvalidInput("a chart is too fine or too thin to be laid out in double precision");
  const Points on_circle = disc.x;
  lower_all(disc, options, Crossing::allowed);
  if (!boundary_crosses(disc, disc.x)) return;
  disc.x = on_circle;
  lower_all(disc, options, Crossing::refused);
}

}  // namespace

FlatCharts flatten(const Surface& surface, const std::vector<char>& seams,
                   const FlattenOptions& options, const Progress& progress) {
  FlatCharts flat;
  std::vector<Disc> discs = cut(surface, seams, flat);
  parallel_for(
      std::ssize(discs),
      [&](std::int64_t c) {
        progress.check();
        flatten_disc(discs[c], options);
      },
      1);
  for (const Disc& disc : discs)
    for (std::size_t v = 0; v < disc.ids.size(); ++v) flat.uvs[disc.ids[v]] = disc.x[v];
  progress.at(1);
  return flat;
}

}  // namespace mq
