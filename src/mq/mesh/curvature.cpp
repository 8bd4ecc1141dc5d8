// In the plane of the vertex normal, with lengths divided by the size h of the neighbourhood, the
// surface is the height
//
//   z(x, y) = c₀ x + c₁ y + c₂ x² + c₃ xy + c₄ y² + c₅ x³ + c₆ x²y + c₇ xy² + c₈ y³,
//
// which passes through the vertex. Its fundamental forms at the vertex are
//
//   I = [1 + c₀², c₀c₁; c₀c₁, 1 + c₁²],   II = [2c₂, c₃; c₃, 2c₄] / √(1 + c₀² + c₁²),
//
// and the shape operator dN is −I⁻¹ II. The coefficients are least squares, with a ridge so small
// (1e-10 of the number of neighbours) that it decides only what the neighbours leave open.

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/dense.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using Matrix2 = Eigen::Matrix2d;

constexpr int cubic = 9;  // coefficients
using Coefficients = Eigen::Matrix<double, cubic, 1>;

/// Two unit vectors that with `normal` make a right-handed frame.
Eigen::Matrix<double, 3, 2> tangents(const Vector3& normal) {
  Eigen::Matrix<double, 3, 2> frame;
  frame.col(0) = normal.unitOrthogonal();
  frame.col(1) = normal.cross(Vector3(frame.col(0)));
  return frame;
}

/// Vertices next to each vertex, each once.
struct Neighbours {
  std::vector<std::int64_t> begin;
  std::vector<int> vertices;

  explicit Neighbours(const Surface& surface) : begin(surface.mesh.positions.size() + 1) {
    const auto each_pair = [&](const auto& use) {
      for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
        const Triangle& t = surface.mesh.triangles[h / 3];
        const int a = t[h % 3], b = t[(h % 3 + 1) % 3];
        if (surface.degenerate[h / 3] || a == b) continue;
        use(a, b);
        const HalfEdge twin = surface.twins[h];
        if (twin < 0 || surface.degenerate[twin / 3]) use(b, a);
      }
    };
    each_pair([&](int a, int) { ++begin[a + 1]; });
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    vertices.resize(begin.back());
    std::vector<std::int64_t> fill(begin.begin(), begin.end() - 1);
    each_pair([&](int a, int b) { vertices[fill[a]++] = b; });
  }

  /// The vertices within `rings` edges of v, v left out; a ring more while they are fewer than
  /// `enough` and there are more.
  void around(int v, int rings, std::size_t enough, std::vector<int>& found) const {
    found.assign(1, v);
    std::size_t ring = 0;
    for (int k = 0; k < rings || found.size() <= enough; ++k) {
      const std::size_t end = found.size();
      for (; ring < end; ++ring)
        for (std::int64_t i = begin[found[ring]]; i < begin[found[ring] + 1]; ++i)
          if (std::find(found.begin(), found.end(), vertices[i]) == found.end())
            found.push_back(vertices[i]);
      if (found.size() == end) break;
    }
    found.erase(found.begin());
  }
};

/// Eigenpairs of a symmetric form on the plane of `frame` (orthonormal columns).
PrincipalCurvatures principal(const Matrix2& shape, const Eigen::Matrix<double, 3, 2>& frame) {
  const auto [values, e] = symmetric_pairs(shape);
  return {values[1], values[0], frame * e.col(1), frame * e.col(0)};
}

/// The curvatures at the origin of the height with gradient (c₀, c₁) and second derivatives
/// (2c₂, c₃, 2c₄), in units of the frame. The form is made symmetric in an orthonormal basis of the
/// tilted tangent plane.
PrincipalCurvatures at_vertex(const Coefficients& c, const Vector3& normal,
                              const Eigen::Matrix<double, 3, 2>& frame) {
  Eigen::Matrix<double, 3, 2> tangent;  // of the fitted surface
  tangent.col(0) = frame.col(0) + c[0] * normal;
  tangent.col(1) = frame.col(1) + c[1] * normal;
  Matrix2 second;
  second << 2 * c[2], c[3], c[3], 2 * c[4];
  second /= std::sqrt(1 + c[0] * c[0] + c[1] * c[1]);
  const Matrix2 first = tangent.transpose() * tangent;
  const Matrix2 root = Matrix2(first.llt().matrixL()).inverse();  // root · first · rootᵀ = 1
  return principal(-root * second * root.transpose(), tangent * root.transpose());
}

PrincipalCurvatures fit(const std::vector<Vector3>& positions, int v, const Vector3& normal,
                        const std::vector<int>& around) {
  const Eigen::Matrix<double, 3, 2> frame = tangents(normal);
  PrincipalCurvatures none{0, 0, frame.col(0), frame.col(1)};
  double size = 0;
  for (const int n : around) size += (positions[n] - positions[v]).norm() / double(around.size());
  if (!(size > 0)) return none;
  const double third = around.size() >= cubic + 3 ? 1 : 0;  // whether there are cubic terms
  Eigen::Matrix<double, cubic, cubic> normal_matrix =
      1e-10 * double(around.size()) * Eigen::Matrix<double, cubic, cubic>::Identity();
  Coefficients right = Coefficients::Zero();
  for (const int n : around) {
    const Vector3 d = (positions[n] - positions[v]) / size;
    const double x = frame.col(0).dot(d), y = frame.col(1).dot(d);
    Coefficients powers;
    powers << x, y, x * x, x * y, y * y,
        third * Eigen::Vector4d(x * x * x, x * x * y, x * y * y, y * y * y);
    normal_matrix.noalias() += powers * powers.transpose();
    right += powers * normal.dot(d);
  }
  const Coefficients c = normal_matrix.ldlt().solve(right);
  if (!c.allFinite()) return none;
  PrincipalCurvatures found = at_vertex(c, normal, frame);
  found.max /= size;
  found.min /= size;
  return found;
}

}  // namespace

std::vector<PrincipalCurvatures> vertex_curvatures(const Surface& surface,
                                                   const CurvatureOptions& options,
                                                   const Progress& progress) {
  std::vector<int> all(surface.mesh.positions.size());
  std::iota(all.begin(), all.end(), 0);
  return vertex_curvatures(surface, all, options, progress);
}

std::vector<PrincipalCurvatures> vertex_curvatures(const Surface& surface, std::span<const int> vertices,
                                                   const CurvatureOptions& options,
                                                   const Progress& progress) {
  require(options.rings >= 1, "curvatures need at least one ring of neighbours");
  std::vector<PrincipalCurvatures> curvatures(vertices.size());
  if (vertices.empty()) return curvatures;
  const Mesh& mesh = surface.mesh;
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const Neighbours neighbours(surface);
  parallel_blocks(std::ssize(vertices), 1024, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    std::vector<int> around;
    for (std::int64_t i = begin; i < end; ++i) {
      const int v = vertices[std::size_t(i)];
      neighbours.around(v, options.rings, cubic + 3, around);
      if (!normals[v].isZero()) curvatures[std::size_t(i)] = fit(mesh.positions, v, normals[v], around);
    }
  });
  progress.at(1);
  return curvatures;
}

std::vector<PrincipalCurvatures> triangle_curvatures(
    const Surface& surface, const std::vector<PrincipalCurvatures>& vertices) {
  std::vector<PrincipalCurvatures> curvatures(surface.mesh.triangles.size());
  parallel_for(std::ssize(curvatures), [&](std::int64_t t) {
    if (surface.degenerate[t]) return;
    Eigen::Matrix3d shape = Eigen::Matrix3d::Zero();
    for (const int v : surface.mesh.triangles[t]) {
      const PrincipalCurvatures& k = vertices[v];
      shape += (k.max * k.max_direction * k.max_direction.transpose() +
                k.min * k.min_direction * k.min_direction.transpose()) /
               3;
    }
    const auto frame = tangents(triangle_normal(surface.mesh, int(t)));
    curvatures[t] = principal(frame.transpose() * shape * frame, frame);
  });
  return curvatures;
}

}  // namespace mq
