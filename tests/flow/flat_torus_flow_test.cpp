// Shifts of a flat torus folded in space: the one closed surface on which the same vector
// everywhere is a motion.

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "mq/base/random.h"
#include "mq/fem/flat_triangle.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

using std::numbers::pi;

/// The torus, and the plane it is rolled from at the same scale.
struct FlatTorus {
  Surface surface;
  std::vector<Vector2> corners;   ///< places in the plane, 3 per triangle
  std::vector<Vector2> vertices;  ///< one of the places of each
  Eigen::Matrix2d periods;        ///< columns: shifts of the plane that are none on the torus
  double spacing = 0;

  explicit FlatTorus(int triangles)
      : surface(make_surface(make_sample("flat_torus", {.triangles = triangles}).mesh)),
        vertices(surface.mesh.vertex_count(), Vector2::Constant(NAN)),
        periods(Eigen::Matrix2d::Zero()) {
    const Mesh& mesh = surface.mesh;
    const auto uv = [&](int t, int k) { return mesh.uvs[mesh.corner_uvs[t][k]]; };
    const double scale =
        (mesh.position(0, 1) - mesh.position(0, 0)).norm() / (uv(0, 1) - uv(0, 0)).norm();
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) {
        corners.push_back(scale * uv(t, k));
        Vector2& place = vertices[mesh.triangles[t][k]];
        if (!place.allFinite()) place = corners.back();
        const Vector2 period = corners.back() - place;
        if (period.norm() > 0.1) periods.col(std::abs(period.y()) < 1e-6 ? 0 : 1) = period;
      }
    spacing = std::sqrt(2 / std::sqrt(3.0) * surface.area / mesh.vertex_count());
  }

  /// Three channels of waves not shorter than `shortest` spacings, as strong as they are long,
  /// shifted.
  Signal waves(double shortest, const Vector2& shift) const {
    const Eigen::Matrix2d numbers = 2 * pi * periods.inverse().transpose();
    const Random random(5);
    std::uint64_t drawn = 0;
    Signal signal = Signal::Zero(surface.mesh.vertex_count(), 3);
    for (int a = -30; a <= 30; ++a)
      for (int b = 0; b <= 30; ++b) {
        const Vector2 k = numbers * Vector2(a, b);
        if ((b == 0 && a <= 0) || k.norm() > 2 * pi / (shortest * spacing)) continue;
        for (int c = 0; c < 3; ++c) {
          const double phase = 2 * pi * random.uniform(drawn++);
          for (int v = 0; v < signal.rows(); ++v)
            signal(v, c) += std::cos(k.dot(vertices[v] - shift) + phase) / k.norm();
        }
      }
    return signal;
  }

  /// X in the plane, per triangle.
  std::vector<Vector2> rolled_out(const Vector& field) const {
    const std::vector<Vector3> X = field_in_space(surface, field);
    std::vector<Vector2> flat;
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3& origin = surface.mesh.position(t, 0);
      Eigen::Matrix<double, 3, 2> edges;
      edges << surface.mesh.position(t, 1) - origin, surface.mesh.position(t, 2) - origin;
      Eigen::Matrix2d plane;
      plane << corners[3 * t + 1] - corners[3 * t], corners[3 * t + 2] - corners[3 * t];
      const Eigen::Matrix2d products = edges.transpose() * edges;
      flat.emplace_back(plane * (products.inverse() * (edges.transpose() * X[t])));
    }
    return flat;
  }

  Vector areas() const {
    Vector all(surface.triangle_count());
    const std::vector<FlatTriangle> shapes = flat_triangles(surface);
    for (int t = 0; t < all.size(); ++t) all[t] = shapes[t].area();
    return all;
  }

  /// The mean distance of X from the shift, in spacings.
  double error(const Vector& field, const Vector2& shift) const {
    const std::vector<Vector2> X = rolled_out(field);
    const Vector area = areas();
    double sum = 0;
    for (int t = 0; t < surface.triangle_count(); ++t) sum += area[t] * (X[t] - shift).norm();
    return sum / surface.area / spacing;
  }
};

/// Scales from as large as the shift, at least 8 spacings.
MeshFlow flow_of(const FlatTorus& torus, const Vector2& shift, FlowBasis basis, FlowSolver solver) {
  MeshFlowOptions options;
  options.basis = basis;
  options.solver = solver;
  options.detail = {0, Length::Unit::percent};
  options.largest = {std::max(8 * torus.spacing, shift.norm()), Length::Unit::model};
  return mesh_flow(torus.surface, torus.waves(6, Vector2::Zero()), torus.waves(6, shift), options);
}

Vector2 shift_by(double length, double angle) {
  return length * Vector2(std::cos(angle), std::sin(angle));
}

TEST(FlatTorusFlow, FindsShiftsToATenthOfASpacing) {
  const FlatTorus torus(9216);
  for (const FlowBasis basis : {FlowBasis::vertex, FlowBasis::triangle, FlowBasis::whitney})
    for (const auto& [spacings, angle] : {std::pair{3.0, 0.3}, {8.0, 1.7}, {20.0, 1.7}}) {
      const Vector2 shift = shift_by(spacings * torus.spacing, angle);
      const MeshFlow flow = flow_of(torus, shift, basis, FlowSolver::direct);
      EXPECT_LE(torus.error(flow.field, shift), 0.1) << int(basis) << ' ' << spacings;
      EXPECT_LE(flow.errors().back(), 1e-3 * flow.blend_error) << int(basis) << ' ' << spacings;
    }
}

/// Coarser meshes cut the folds, so what they find there is off; the signals still meet.
TEST(FlatTorusFlow, FindsThemOverCoarserMeshesButForTheFolds) {
  const FlatTorus torus(9216);
  const Vector2 shift = shift_by(3 * torus.spacing, 0.3);
  const MeshFlow flow = flow_of(torus, shift, FlowBasis::vertex, FlowSolver::hierarchical);
  EXPECT_LE(torus.error(flow.field, shift), 0.3);
  EXPECT_LE(flow.errors().back(), 0.01 * flow.blend_error);
}

/// ∫ ∇φ dA and ∫ J∇φ dA vanish in the plane: no shift at all in the basis of gradients.
TEST(FlatTorusFlow, OfGradientsIsNoShift) {
  const FlatTorus torus(2304);
  const MeshFlow flow =
      flow_of(torus, shift_by(3 * torus.spacing, 0.3), FlowBasis::gradient, FlowSolver::direct);
  const std::vector<Vector2> X = torus.rolled_out(flow.field);
  const Vector area = torus.areas();
  Vector2 sum = Vector2::Zero();
  double all = 0;
  for (int t = 0; t < area.size(); ++t) {
    sum += area[t] * X[t];
    all += area[t] * X[t].norm();
  }
  EXPECT_GT(all, 0.01 * torus.spacing * torus.surface.area);
  EXPECT_LE(sum.norm(), 1e-9 * all);
}

}  // namespace
}  // namespace mq
