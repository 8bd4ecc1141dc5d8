// With J = [a b; c d] and e = (a + d)/2, f = (a − d)/2, g = (c + b)/2, h = (c − b)/2 the singular
// values are σ₁,₂ = q ± r with q = |(e, h)|, r = |(f, g)|; the nearest rotation is [e −h; h e] / q,
// and the left singular vectors make the angle φ with 2φ = arg(f, g) + arg(e, h). Of the energy
//
//   E = Σ A ½ |J|² (1 + 1/det²),   ∂E/∂J = A (J (1 + 1/det²) − |J|²/det³ cof J),
//
// and the quadratic model of a step has the matrix A M ⊗ G Gᵀ with M = U diag(w) Uᵀ,
// w = (σ − σ⁻³) / (σ − 1) = σ⁻³ (σ + 1)(σ² + 1) > 0. The right side is the true gradient, so
// a step never ascends.

#include "mq/unwrap/detail/parametrize.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/mesh/first_flat.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/tutte.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

using Matrix2 = Eigen::Matrix2d;

/// Height to longest side of the thinnest rest shape.
constexpr double thinnest = 1e-4;

// ---- Sheets ----

/// The gradients of a triangle's hats, laid out with its longest edge, which starts at corner
/// `first`, on the x-axis; `foot` and `height` say where the corner across from it is.
void add_rest_shape(int first, double longest, double foot, double height, Sheet& sheet) {
  const int second = (first + 1) % 3, third = (first + 2) % 3;
  const double length = std::max(longest, std::numeric_limits<double>::min());
  foot = std::clamp(foot, 0.0, length);
  height = std::max(height, thinnest * length);
  Eigen::Matrix<double, 3, 2> G;
  G.row(second) = Eigen::RowVector2d(1 / length, -foot / (length * height));
  G.row(third) = Eigen::RowVector2d(0, 1 / height);
  G.row(first) = -G.row(second) - G.row(third);
  sheet.areas.push_back(length * height / 2);
  sheet.gradients.push_back(G);
}

void add_rest_shape(const Mesh& mesh, int t, Sheet& sheet) {
  int first = 0;
  double longest = -1;
  for (int k = 0; k < 3; ++k) {
    const double length = (mesh.position(t, (k + 1) % 3) - mesh.position(t, k)).norm();
    if (length > longest) longest = length, first = k;
  }
  const Vector3 base = mesh.position(t, (first + 1) % 3) - mesh.position(t, first);
  const Vector3 side = mesh.position(t, (first + 2) % 3) - mesh.position(t, first);
  const double length = std::max(longest, std::numeric_limits<double>::min());
  add_rest_shape(first, longest, base.dot(side) / length, base.cross(side).norm() / length, sheet);
}

void add_rest_shape(const std::array<double, 3>& edges, Sheet& sheet) {
  const int first = int(std::ranges::max_element(edges) - edges.begin());
  const double length = std::max(edges[first], std::numeric_limits<double>::min());
  const double side = edges[(first + 2) % 3], opposite = edges[(first + 1) % 3];
  const double foot = (length * length + side * side - opposite * opposite) / (2 * length);
  const double height = std::sqrt(std::max(side * side - foot * foot, 0.0));
  add_rest_shape(first, length, foot, height, sheet);
}

/// Follows the edges that have no partner.
void find_loops(const std::vector<std::array<int, 3>>& edges, Sheet& sheet) {
  std::vector<int> after(sheet.vertex_count, -1), half_edge(sheet.vertex_count);
  for (const auto& [from, to, h] : edges) {
    require(after[from] < 0, "a chart touches itself in a vertex");
    after[from] = to;
    half_edge[from] = h;
  }
  std::vector<char> seen(sheet.vertex_count);
  for (const auto& edge : edges) {
    if (seen[edge[0]]) continue;
    sheet.loops.emplace_back();
    sheet.edges.emplace_back();
    for (int v = edge[0]; v >= 0 && !seen[v]; v = after[v]) {
      seen[v] = 1;
      sheet.loops.back().push_back(v);
      sheet.edges.back().push_back(half_edge[v]);
    }
  }
}

// ---- Jacobians ----

Matrix2 jacobian(const Sheet& sheet, std::size_t t, const Points& x) {
  const Triangle& v = sheet.triangles[t];
  const auto& G = sheet.gradients[t];
  Matrix2 J = x[v[0]] * G.row(0);
  J += x[v[1]] * G.row(1);
  J += x[v[2]] * G.row(2);
  return J;
}

// ---- A matrix with two unknowns per vertex, whose pattern is known once ----

class PairMatrix {
 public:
  explicit PairMatrix(const Sheet& sheet) : slots_(sheet.triangles.size()) {
    const int n = sheet.vertex_count;
    std::vector<std::vector<int>> around(n);
    for (int v = 0; v < n; ++v) around[v].push_back(v);
    for (const Triangle& t : sheet.triangles)
      for (const int i : t)
        for (const int j : t)
          if (std::ranges::find(around[i], j) == around[i].end()) around[i].push_back(j);
    begin_.assign(n + 1, 0);
    for (int v = 0; v < n; ++v) {
      std::ranges::sort(around[v]);
      begin_[v + 1] = begin_[v] + int(around[v].size());
    }
    matrix_.resize(2 * n, 2 * n);
    matrix_.resizeNonZeros(4 * begin_[n]);
    for (int v = 0; v < n; ++v)
      for (int a = 0; a < 2; ++a) {
        int k = matrix_.outerIndexPtr()[2 * v + a] = 4 * begin_[v] + a * 2 * degree(v);
        for (const int j : around[v])
          for (int b = 0; b < 2; ++b) matrix_.innerIndexPtr()[k++] = 2 * j + b;
      }
    matrix_.outerIndexPtr()[2 * n] = 4 * begin_[n];
    for (std::size_t t = 0; t < slots_.size(); ++t)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const auto& row = around[sheet.triangles[t][i]];
          slots_[t][3 * i + j] =
              int(std::ranges::lower_bound(row, sheet.triangles[t][j]) - row.begin());
        }
  }

  void clear() { std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0); }

  /// Adds a 2 × 2 block at corners i and j of triangle t, whose vertex at i is `v`.
  void add(std::size_t t, int i, int j, int v, const Matrix2& block) {
    double* row = matrix_.valuePtr() + 4 * begin_[v] + 2 * slots_[t][3 * i + j];
    row[0] += block(0, 0), row[1] += block(0, 1);
    row += 2 * degree(v);
    row[0] += block(1, 0), row[1] += block(1, 1);
  }

  void add_to_diagonal(int row, double value) { matrix_.coeffRef(row, row) += value; }
  double trace() const { return matrix_.diagonal().sum(); }
  const SparseMatrix& matrix() const { return matrix_; }

 private:
  int degree(int v) const { return begin_[v + 1] - begin_[v]; }

  std::vector<int> begin_;                 // per vertex, where its neighbours begin
  std::vector<std::array<int, 9>> slots_;  // per triangle and pair of corners, place in the row
  SparseMatrix matrix_;
};

Points as_points(const Signal& x) {
  Points points(std::size_t(x.rows()) / 2);
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v] = {x(2 * Eigen::Index(v), 0), x(2 * Eigen::Index(v) + 1, 0)};
  return points;
}

// ---- Lowering the energy ----

/// Fills matrix and gradient of the quadratic model at x.
void quadratic_model(const Sheet& sheet, const Points& x, PairMatrix& matrix, Signal& gradient) {
  matrix.clear();
  gradient.setZero();
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const Matrix2 J = jacobian(sheet, t, x);
    const double e = (J(0, 0) + J(1, 1)) / 2, f = (J(0, 0) - J(1, 1)) / 2;
    const double g = (J(1, 0) + J(0, 1)) / 2, h = (J(1, 0) - J(0, 1)) / 2;
    const double q = std::hypot(e, h), r = std::hypot(f, g);
    const auto weight = [](double s) {
      s = std::max(s, 1e-6);
      return (s + 1) * (s * s + 1) / (s * s * s);
    };
    const double w1 = weight(q + r), w2 = weight(q - r), qr = q * r;
    const double c = qr > 0 ? (f * e - g * h) / qr : 1, s = qr > 0 ? (g * e + f * h) / qr : 0;
    const double mean = (w1 + w2) / 2, half = (w1 - w2) / 2;
    Matrix2 M;
    M << mean + half * c, half * s, half * s, mean - half * c;
    const double det = q * q - r * r, norm = J.squaredNorm();
    Matrix2 cofactor;
    cofactor << J(1, 1), -J(1, 0), -J(0, 1), J(0, 0);
    const Matrix2 D =
        sheet.areas[t] * (J * (1 + 1 / (det * det)) - cofactor * (norm / (det * det * det)));
    const auto& G = sheet.gradients[t];
    for (int i = 0; i < 3; ++i) {
      const int v = sheet.triangles[t][i];
      const Vector2 slope = D * G.row(i).transpose();
      gradient(2 * v, 0) += slope.x();
      gradient(2 * v + 1, 0) += slope.y();
      for (int j = 0; j < 3; ++j)
        matrix.add(t, i, j, v, (sheet.areas[t] * G.row(i).dot(G.row(j))) * M);
    }
  }
  // Translations and rotations cost nothing; they are held softly.
  const int rows = 2 * sheet.vertex_count;
  const double hold = 1e-8 * matrix.trace() / rows;
  for (int i = 0; i < rows; ++i) matrix.add_to_diagonal(i, hold);
}

/// Scales to the sheet's area, so that the energy starts near its least.
void scale_to_area(const Sheet& sheet, Points& x) {
  double area = 0;
  for (const Triangle& t : sheet.triangles) area += cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]) / 2;
  if (!(area > 0)) return;
  const double scale = std::sqrt(sheet.area / area);
  for (Vector2& p : x) p *= scale;
}

struct LoopEdge {
  Vector2 a, b;
  int loop, place, count;
  double low, high;
};

bool crosses(const LoopEdge& e, const LoopEdge& f) {
  const int apart = std::abs(e.place - f.place);
  if (e.loop == f.loop && (apart == 1 || apart == e.count - 1)) return false;
  if (std::max(e.a.y(), e.b.y()) < std::min(f.a.y(), f.b.y()) ||
      std::max(f.a.y(), f.b.y()) < std::min(e.a.y(), e.b.y()))
    return false;
  const auto side = [](const Vector2& p, const Vector2& q, const Vector2& r) {
    const double s = cross(q - p, r - p);
    return (s > 0) - (s < 0);
  };
  return side(e.a, e.b, f.a) * side(e.a, e.b, f.b) <= 0 &&
         side(f.a, f.b, e.a) * side(f.a, f.b, e.b) <= 0;
}

}  // namespace

bool Sheet::is_disc() const {
  if (loops.size() != 1) return false;
  const auto boundary = std::ssize(loops[0]), count = std::ssize(triangles);
  return 2 * vertex_count - (3 * count + boundary) + 2 * count == 2;
}

Sheet make_sheet(const Surface& surface, const std::vector<int>& triangles,
                 const std::vector<char>& merged, const EdgeLengths* lengths) {
  Sheet sheet;
  sheet.sources = triangles;
  sheet.triangles.resize(triangles.size());
  std::vector<int> order(triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = int(i);
  std::ranges::sort(order, {}, [&](int i) { return triangles[i]; });
  const auto local = [&](int triangle) {
    const auto at =
        std::ranges::lower_bound(order, triangle, {}, [&](int i) { return triangles[i]; });
    return *at;
  };
  DisjointSets corners(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const HalfEdge h = 3 * triangles[i] + k, twin = surface.twins[h];
      if (!merged[h]) continue;
      const int j = 3 * local(twin / 3) + twin % 3;
      corners.join(3 * int(i) + k, next(j));
      corners.join(next(3 * int(i) + k), j);
    }
  std::vector<int> vertex(3 * triangles.size());
  for (int c = 0; c < int(vertex.size()); ++c) {
    const int root = corners.root(c);
    if (root == c) vertex[c] = sheet.vertex_count++;
    sheet.triangles[c / 3][c % 3] = vertex[c] = vertex[root];
  }
  std::vector<std::array<int, 3>> edges;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (!merged[3 * triangles[i] + k])
        edges.push_back(
            {sheet.triangles[i][k], sheet.triangles[i][(k + 1) % 3], 3 * triangles[i] + k});
  find_loops(edges, sheet);
  for (const int t : triangles)
    if (lengths)
      add_rest_shape((*lengths)[t], sheet);
    else
      add_rest_shape(surface.mesh, t, sheet);
  for (const double a : sheet.areas) sheet.area += a;
  return sheet;
}

double isometric_energy(const Sheet& sheet, const Points& x) {
  double sum = 0;
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const Matrix2 J = jacobian(sheet, t, x);
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    if (!(det > 0)) return infinity;
    sum += sheet.areas[t] * (0.5 * J.squaredNorm() * (1 + 1 / (det * det)) - 2);
  }
  return sum;
}

double l2_stretch(const Sheet& sheet, const Points& x) {
  double stretch = 0, area = 0;
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const Matrix2 J = jacobian(sheet, t, x);
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    if (!(det > 0)) return infinity;
    stretch += sheet.areas[t] * 0.5 * J.squaredNorm() / (det * det);
    area += sheet.areas[t] * det;
  }
  return std::sqrt(stretch * area) / sheet.area;
}

std::vector<std::array<HalfEdge, 2>> crossings(const Sheet& sheet, const Points& x, int most) {
  std::vector<LoopEdge> edges;
  for (int l = 0; l < int(sheet.loops.size()); ++l) {
    const auto& loop = sheet.loops[l];
    const int count = int(loop.size());
    for (int i = 0; i < count; ++i) {
      const Vector2 &a = x[loop[i]], &b = x[loop[(i + 1) % count]];
      edges.push_back({a, b, l, i, count, std::min(a.x(), b.x()), std::max(a.x(), b.x())});
    }
  }
  std::ranges::stable_sort(edges, {}, &LoopEdge::low);
  std::vector<std::array<HalfEdge, 2>> found;
  const auto half_edge = [&](const LoopEdge& e) { return sheet.edges[e.loop][e.place]; };
  for (std::size_t i = 0; i < edges.size() && std::ssize(found) < most; ++i)
    for (std::size_t j = i + 1; j < edges.size() && edges[j].low <= edges[i].high; ++j)
      if (crosses(edges[i], edges[j]) && std::ssize(found) < most)
        found.push_back({half_edge(edges[i]), half_edge(edges[j])});
  return found;
}

bool is_injective(const Sheet& sheet, const Points& x) {
  int outer = 0;
  for (const std::vector<int>& loop : sheet.loops) {
    double area = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      area += cross(x[loop[i]] - x[loop[0]], x[loop[(i + 1) % loop.size()]] - x[loop[0]]);
    outer += area > 0;
  }
  return outer == 1 && !boundary_crosses(sheet, x);
}

Points tutte_embedding(const Sheet& sheet, Factorisation kind) {
  require(sheet.is_disc(), "Tutte's embedding is one of discs");
  return tutte_embedding(sheet.vertex_count, sheet.triangles, sheet.loops[0], sheet.area, kind);
}

Points conformal_map(const Sheet& sheet, Factorisation kind) {
  // ½ Σ A |J|² − Σ A det J: Dirichlet energy less area, 0 for conformal maps.
  PairMatrix matrix(sheet);
  matrix.clear();
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& G = sheet.gradients[t];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double dot = G.row(i).dot(G.row(j));
        const double turn = G(i, 0) * G(j, 1) - G(i, 1) * G(j, 0);
        Matrix2 block;
        block << dot, -turn, turn, dot;
        matrix.add(t, i, j, sheet.triangles[t][i], sheet.areas[t] * block);
      }
  }
  // Pins: as if springs held them, a thousand times stiffer than an edge.
  const std::vector<int>& loop =
      *std::ranges::max_element(sheet.loops, {}, [](const auto& l) { return l.size(); });
  const std::array<int, 2> pins{loop[0], loop[loop.size() / 2]};
  const int rows = 2 * sheet.vertex_count;
  const double mean = matrix.trace() / rows, spring = 1e3 * mean;
  Signal right = Signal::Zero(rows, 1);
  right(2 * pins[1], 0) = spring * std::sqrt(sheet.area);
  for (const int pin : pins)
    for (int a = 0; a < 2; ++a) matrix.add_to_diagonal(2 * pin + a, spring);
  for (int i = 0; i < rows; ++i) matrix.add_to_diagonal(i, 1e-10 * mean);
  Points x = as_points(DirectSolver(matrix.matrix(), kind).solve(right));
  scale_to_area(sheet, x);
  return x;
}

Points as_rigid_as_possible(const Sheet& sheet, Points x, int iterations, Factorisation kind) {
  Entries entries;
  entries.reserve(9 * sheet.triangles.size() + sheet.vertex_count);
  double trace = 0;
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double k = sheet.areas[t] * sheet.gradients[t].row(i).dot(sheet.gradients[t].row(j));
        entries.emplace_back(sheet.triangles[t][i], sheet.triangles[t][j], k);
        if (i == j) trace += k;
      }
  const double hold = 1e-8 * trace / sheet.vertex_count;
  for (int v = 0; v < sheet.vertex_count; ++v) entries.emplace_back(v, v, hold);
  const DirectSolver solver(sparse_matrix(sheet.vertex_count, sheet.vertex_count, entries), kind);
  Signal right(sheet.vertex_count, 2);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    right.setZero();
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      const Matrix2 J = jacobian(sheet, t, x);
      const double e = J(0, 0) + J(1, 1), h = J(1, 0) - J(0, 1), q = std::hypot(e, h);
      Matrix2 R = Matrix2::Identity();
      if (q > 0) R << e / q, -h / q, h / q, e / q;
      for (int i = 0; i < 3; ++i)
        right.row(sheet.triangles[t][i]) +=
            sheet.areas[t] * (R * sheet.gradients[t].row(i).transpose()).transpose();
    }
    const Signal solution = solver.solve(right);
    for (int v = 0; v < sheet.vertex_count; ++v) x[v] = solution.row(v).transpose();
  }
  return x;
}

Points lower_energy(const Sheet& sheet, Points x, const LowerOptions& options,
                    const Progress& progress) {
  PairMatrix matrix(sheet);
  Signal gradient(2 * sheet.vertex_count, 1);
  std::optional<DirectSolver> solver;
  double before = isometric_energy(sheet, x);
  require(std::isfinite(before), "a map that folds cannot be lowered");
  // A single triangle about to flip can hold up a step, but not many in a row.
  for (int i = 0, idle = 0; i < options.iterations && idle < 2; ++i) {
    progress.check();
    quadratic_model(sheet, x, matrix, gradient);
    if (solver)
      solver->refactor(matrix.matrix());
    else
      solver.emplace(matrix.matrix(), options.factorisation);
    const Signal step = solver->solve(-gradient);
    const Points direction = as_points(step);
    const double slope = (step.transpose() * gradient)(0, 0);
    double length = std::min(1.0, 0.8 * first_flat(sheet.triangles, x, direction));
    bool found = false;
    for (int halvings = 0; halvings < 30 && !found; ++halvings, length /= 2) {
      Points moved = x;
      for (std::size_t v = 0; v < x.size(); ++v) moved[v] += length * direction[v];
      const double after = isometric_energy(sheet, moved);
      if (!(after <= before + 1e-4 * length * slope)) continue;
      if (options.crossing == LowerOptions::Crossing::refused && boundary_crosses(sheet, moved))
        continue;
      // Relative to the area too: an isometry has no energy to be relative to.
      const double decrease = (before - after) / (before + 0.05 * sheet.area);
      idle = decrease < options.tolerance ? idle + 1 : 0;
      x = std::move(moved);
      before = after;
      found = true;
    }
    if (!found) break;
  }
  return x;
}

Points parametrize(const Sheet& sheet, const LowerOptions& options, const Progress& progress) {
  const auto folds = [&](const Points& x) { return !std::isfinite(isometric_energy(sheet, x)); };
  if (sheet.loops.empty()) return {};
  Points x = conformal_map(sheet, options.factorisation);
  {  // nearer to an isometry, at the price of one factorisation
    Points rigid = as_rigid_as_possible(sheet, x, 10, options.factorisation);
    if (folds(x) || !folds(rigid)) x = std::move(rigid);
  }
  if (folds(x) && sheet.is_disc()) x = tutte_embedding(sheet, options.factorisation);
  if (folds(x)) return {};
  return lower_energy(sheet, std::move(x), options, progress);
}

}  // namespace mq
