// Triangles of one surface are added in different frames, so that no frame shows all of them as
// they were. R_t turns the edges at rest to where they are now best; with them the sum is quadratic
// in x, its matrix the same in every round. A weak hold on the positions of now settles where parts
// lie that nothing else holds.

#include "mq/track/rest_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/dense.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

constexpr int rounds = 20;
constexpr double least_weight = 0.05, most_weight = 20;  // of an edge in a triangle
constexpr double hold = 1e-6;                            // of the sum around a vertex

using Corners = std::array<Vector3, 3>;

/// The edge that begins at corner k.
Vector3 edge(const Corners& corners, int k) {
  return corners[std::size_t((k + 1) % 3)] - corners[std::size_t(k)];
}

/// The corners 1 and 2 of a triangle, seen from corner 0, in its plane; columns.
Eigen::Matrix2d flat_corners(const Corners& corners) {
  const Vector3 e = edge(corners, 0), f = corners[2] - corners[0];
  const double length = e.norm();
  Eigen::Matrix2d columns = Eigen::Matrix2d::Zero();
  columns(0, 0) = length;
  if (length > 0) columns.col(1) = Vector2(e.dot(f), e.cross(f).norm()) / length;
  return columns;
}

/// Cotangents of the angles opposite the edges, within bounds.
Vector3 weights(const Corners& corners) {
  Vector3 result;
  for (int k = 0; k < 3; ++k) {
    const Vector3 a = -edge(corners, (k + 1) % 3), b = edge(corners, (k + 2) % 3);
    const double sine = a.cross(b).norm();
    result[k] = std::clamp(sine > 0 ? a.dot(b) / sine : most_weight, least_weight, most_weight);
  }
  return result;
}

/// Two orthonormal vectors along a triangle, the first along its first edge and the second towards its third corner.
Eigen::Matrix<double, 3, 2> plane_of(const Corners& corners) {
  Eigen::Matrix<double, 3, 2> axes;
  const Vector3 e = edge(corners, 0), f = corners[2] - corners[0];
  const double length = e.norm();
  axes.col(0) = length > 0 ? Vector3(e / length) : Vector3(Vector3::UnitX());
  const Vector3 across = f - axes.col(0).dot(f) * axes.col(0);
  const double height = across.norm();
  axes.col(1) = height > 0 ? Vector3(across / height) : Vector3(axes.col(0)).unitOrthogonal();
  return axes;
}

/// A triangle at rest: its edges in its plane, and their weights.
struct RestTriangle {
  Eigen::Matrix<double, 2, 3> edges;
  Vector3 weight;

  explicit RestTriangle(const Corners& corners) : weight(weights(corners)) {
    const Eigen::Matrix<double, 3, 2> axes = plane_of(corners);
    for (int k = 0; k < 3; ++k) edges.col(k) = axes.transpose() * edge(corners, k);
  }

  /// Its edges, turned to where they are nearest to those of `now`, times their weights; columns. Triangles lie in
  /// planes, and the third corner of both is on the same side of the first edge, so that the map between the planes
  /// turns nothing over: the rotation in space is that of the plane nearest to (a, b; c, d), by the angle of
  /// (a + d, c − b).
  Eigen::Matrix3d turned(const Corners& now) const {
    const Eigen::Matrix<double, 3, 2> axes = plane_of(now);
    Eigen::Matrix2d map = Eigen::Matrix2d::Zero();
    for (int k = 0; k < 3; ++k) map += weight[k] * (axes.transpose() * edge(now, k)) * edges.col(k).transpose();
    const double along = map(0, 0) + map(1, 1), across = map(1, 0) - map(0, 1);
    const double length = std::sqrt(along * along + across * across);
    Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
    if (length > 0) turn << along / length, -across / length, across / length, along / length;
    return axes * (turn * edges) * weight.asDiagonal();
  }
};

/// The matrix of the sum in the header, factored, and what its right side is made of.
class RestEquations {
 public:
  RestEquations(const Mesh& now, std::span<const Corners> rest) : around_(now.positions.size(), 0) {
    Entries entries;
    entries.reserve(6 * rest.size() + around_.size());
    triangles_.reserve(rest.size());
    for (int t = 0; t < now.triangle_count(); ++t) {
      triangles_.emplace_back(rest[t]);
      for (int k = 0; k < 3; ++k) {
        const int i = now.triangles[t][k], j = now.triangles[t][(k + 1) % 3];
        const double w = triangles_.back().weight[k];
        around_[i] += w, around_[j] += w;
        entries.emplace_back(i, j, -w);
        entries.emplace_back(j, i, -w);
      }
    }
    for (int v = 0; v < now.vertex_count(); ++v)
      entries.emplace_back(v, v, around_[v] > 0 ? (1 + hold) * around_[v] : 1);
    solver_.emplace(sparse_matrix(now.vertex_count(), now.vertex_count(), entries));
  }

  /// One round from the positions x.
  void improve(const Mesh& now, std::vector<Vector3>& x) const {
    std::vector<Eigen::Matrix3d> turned(triangles_.size());
    parallel_for(std::ssize(triangles_), [&](std::int64_t t) {
      const auto& [a, b, c] = now.triangles[t];
      turned[t] = triangles_[t].turned({x[a], x[b], x[c]});
    });
    Signal right(now.vertex_count(), 3);
    for (int v = 0; v < now.vertex_count(); ++v)
      right.row(v) = (around_[v] > 0 ? hold * around_[v] : 1) * now.positions[v].transpose();
    for (std::size_t t = 0; t < turned.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        right.row(now.triangles[t][(k + 1) % 3]) += turned[t].col(k).transpose();
        right.row(now.triangles[t][k]) -= turned[t].col(k).transpose();
      }
    const Signal solved = solver_->solve(right);
    for (int v = 0; v < now.vertex_count(); ++v) x[v] = solved.row(v).transpose();
  }

 private:
  std::vector<RestTriangle> triangles_;
  std::vector<double> around_;  ///< per vertex the weights of its edges
  std::optional<DirectSolver> solver_;
};

}  // namespace

std::vector<Vector3> rest_shape(const Mesh& now, std::span<const Corners> rest) {
  require(std::ssize(rest) == now.triangle_count(),
          "the rest shape needs the corners of every triangle");
  std::vector<Vector3> result = now.positions;
  const auto corners = [&](int t) {
    const auto& [a, b, c] = now.triangles[t];
    return Corners{result[a], result[b], result[c]};
  };
  bool changed = false;
  for (int t = 0; t < now.triangle_count() && !changed; ++t) changed = corners(t) != rest[t];
  if (!changed) return result;

  const RestEquations equations(now, rest);
  for (int round = 0; round < rounds; ++round) equations.improve(now, result);
  return result;
}

double worst_distortion(const Mesh& now, std::span<const std::array<Vector3, 3>> rest) {
  require(std::ssize(rest) == now.triangle_count(),
          "a rest shape needs the corners of every triangle");
  double worst = 1;
  for (int t = 0; t < now.triangle_count(); ++t) {
    const Eigen::Matrix2d before = flat_corners(rest[t]);
    if (!(before.determinant() > 1e-6 * before.squaredNorm())) continue;
    const Eigen::Matrix2d after =
        flat_corners({now.position(t, 0), now.position(t, 1), now.position(t, 2)});
    const Eigen::Vector2d sigma = singular_values(Eigen::Matrix2d(after * before.inverse())).values;
    const double area = sigma[0] * sigma[1];
    worst = std::max({worst, sigma[0] / std::max(sigma[1], 1e-9), area, 1 / std::max(area, 1e-9)});
  }
  return worst;
}

}  // namespace mq
