// Triangles of one surface are added in different frames, so that no frame shows all of them as
// they were. R_t turns the edges at rest to where they are now best; with them the sum is quadratic
// in x, its matrix the same in every round. A weak hold on the positions of now settles where parts
// lie that nothing else holds.

#include "mq/track/rest_shape.h"

#include <Eigen/Geometry>
#include <algorithm>

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

/// The rotation that takes the edges of one triangle nearest to those of another.
Eigen::Matrix3d rotation(const Corners& from, const Corners& to, const Vector3& weight) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) covariance += weight[k] * edge(to, k) * edge(from, k).transpose();
  return nearest_rotation(singular_values(covariance));
}

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

  Entries entries;
  std::vector<double> around(result.size(), 0);
  std::vector<Vector3> weight;
  for (int t = 0; t < now.triangle_count(); ++t) {
    weight.push_back(weights(rest[t]));
    for (int k = 0; k < 3; ++k) {
      const int i = now.triangles[t][k], j = now.triangles[t][(k + 1) % 3];
      const double w = weight.back()[k];
      around[i] += w, around[j] += w;
      entries.emplace_back(i, j, -w);
      entries.emplace_back(j, i, -w);
    }
  }
  for (int v = 0; v < now.vertex_count(); ++v)
    entries.emplace_back(v, v, around[v] > 0 ? (1 + hold) * around[v] : 1);
  const DirectSolver solver(sparse_matrix(now.vertex_count(), now.vertex_count(), entries));

  for (int round = 0; round < rounds; ++round) {
    std::vector<Eigen::Matrix3d> turns(rest.size());
    parallel_for(std::ssize(rest),
                 [&](std::int64_t t) { turns[t] = rotation(rest[t], corners(int(t)), weight[t]); });
    Signal right(now.vertex_count(), 3);
    for (int v = 0; v < now.vertex_count(); ++v)
      right.row(v) = (around[v] > 0 ? hold * around[v] : 1) * now.positions[v].transpose();
    for (int t = 0; t < now.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Vector3 constraint = weight[t][k] * (turns[t] * edge(rest[t], k));
        right.row(now.triangles[t][(k + 1) % 3]) += constraint.transpose();
        right.row(now.triangles[t][k]) -= constraint.transpose();
      }
    const Signal x = solver.solve(right);
    for (int v = 0; v < now.vertex_count(); ++v) result[v] = x.row(v).transpose();
  }
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
