// What surface flow is made of: its solvers, its coarser meshes, and what is between two signals.
#include "mq/flow/surface_levels.h"

#include <gtest/gtest.h>

#include "flow/moved_signals.h"
#include "mq/base/error.h"
#include "mq/flow/surface_systems.h"

namespace mq {
namespace {

using namespace fixtures;

/// A step of the hierarchical solver is that of the factorisation.
TEST(FlowSolvers, AgreeInTheVertexBasis) {
  const Pair pair = turned_torus(3);
  const FlowMeshes meshes(pair.surface, 200);
  ASSERT_GT(meshes.count(), 1);
  const FlowMesh& mesh = meshes[0];
  const DataTerms data = data_terms(mesh.space(), pair.target - pair.source, pair.source);
  const double weight = 25 * pair.spacing * pair.spacing * data.trace / mesh.area();
  VertexSystem system = vertex_system(mesh, data, weight);
  BlockMultigrid multigrid(meshes.transfers_from(0), {.tolerance = 1e-10});
  multigrid.set_matrix(std::move(system.matrix));
  Vector z = Vector::Zero(system.right_hand_side.size());
  const SolveReport report = multigrid.solve(system.right_hand_side, z);
  EXPECT_LE(report.cycles, 14);
  DirectFlowSolver direct(mesh, FlowBasis::vertex);
  const Vector expected = direct.solve(data, weight);
  EXPECT_LE((mesh.triangle_field(z) - expected).cwiseAbs().maxCoeff(),
            1e-6 * expected.cwiseAbs().maxCoeff());
}

/// What X changes is all that matters: D·Y + w·S·Y + Pᵀg = 0 at the minimum.
TEST(FlowSolvers, MinimiseTheEnergyInEveryBasis) {
  const Pair pair = turned_sphere(0.1);
  const FlowMesh mesh(pair.surface);
  const DataTerms data = data_terms(mesh.space(), pair.target - pair.source, pair.source);
  for (const FlowBasis basis : bases) {
    DirectFlowSolver solver(mesh, basis);
    const Vector small = solver.solve(data, 1e-9 * data.trace),
                 large = solver.solve(data, 1e3 * data.trace);
    // Energy below that of 0: ⟨Y, G·Y⟩ + 2⟨g, Y⟩ + w⟨Y, S·Y⟩ = ⟨g, Y⟩ < 0 at the minimum.
    EXPECT_LT(data.products(small)[0], 0);
    EXPECT_LT(data.products(large)[0], 0);
    EXPECT_LT(data.products(small)[0], data.products(large)[0]) << int(basis);
  }
}

/// A rotation of the sphere, at vertices.
Vector rotation_on(const FlowMesh& mesh) {
  const Vector3 axis = Vector3(0.2, 0.3, 1).normalized();
  Vector z(2 * mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 X = axis.cross(mesh.surface().mesh.positions[v]);
    z.segment<2>(2 * v) = Vector2(X.dot(mesh.axis(v)), X.dot(mesh.normal(v).cross(mesh.axis(v))));
  }
  return z;
}

/// And from triangles back to their corners.
TEST(FlowMeshes, HaveTheSameFieldOnTrianglesAndAtVertices) {
  std::vector<double> errors;
  for (const int level : {3, 4, 5}) {
    const Surface surface = make_surface(fixtures::sphere(level));
    const FlowMesh mesh(surface);
    const Vector z = rotation_on(mesh);
    errors.push_back((mesh.vertex_field(mesh.triangle_field(z)) - z).norm() / z.norm());
  }
  EXPECT_LE(errors[2], 5e-3);
  EXPECT_GE(std::log2(errors[1] / errors[2]), 1.7);
}

TEST(FlowMeshes, CarryRotationsOfTheSphereFromCoarseToFine) {
  const Surface surface = make_surface(fixtures::sphere(5));
  const FlowMeshes meshes(surface, 200);
  ASSERT_GE(meshes.count(), 3);
  std::vector<double> errors;
  for (int m = 0; m < 2; ++m) {
    const Vector fine = rotation_on(meshes[m]);
    const Vector found = meshes.transfer(m)->prolongated(rotation_on(meshes[m + 1]));
    errors.push_back((found - fine).norm() / fine.norm());
  }
  EXPECT_LE(errors[0], 0.02);
  EXPECT_LE(errors[0], 0.5 * errors[1]);
}

TEST(FlowMeshes, KeepConstantsAndMeans) {
  const Surface surface = make_surface(fixtures::torus(60, 30));
  const FlowMeshes meshes(surface, 200);
  const Signal constant = Signal::Constant(surface.mesh.vertex_count(), 2, 0.7);
  const Signal coarse = meshes.restricted(0, constant);
  EXPECT_LE((coarse.array() - 0.7).abs().maxCoeff(), 1e-12);
  EXPECT_LE((meshes.prolongated(0, coarse).array() - 0.7).abs().maxCoeff(), 1e-6);
}

TEST(Interpolation, BeginsAndEndsWithTheSignalsThemselves) {
  const Pair pair = turned_torus(3, 40);
  const TraceMesh mesh(pair.surface);
  const Vector field = mesh_flow(pair.surface, pair.source, pair.target, from(15)).field;
  EXPECT_EQ(interpolate(mesh, field, pair.source, pair.target, 0), pair.source);
  EXPECT_EQ(interpolate(mesh, field, pair.source, pair.target, 1), pair.target);
  EXPECT_THROW(interpolate(mesh, field, pair.source, pair.target, 1.5), InvalidInput);
}

/// Halfway is the source turned by half the angle, and not a blend of two.
TEST(Interpolation, ShowsTheMotionHalfway) {
  const double angle = 0.3;
  const Pair pair = moved(fixtures::torus(120, 60), 2, rotation(angle, Vector3::UnitZ()));
  const TraceMesh mesh(pair.surface);
  const Vector field = mesh_flow(pair.surface, pair.source, pair.target, from(20)).field;
  for (const double t : {0.25, 0.5, 0.75}) {
    const Signal truth = colours(pair.surface, 2, rotation(t * angle, Vector3::UnitZ()));
    const Signal found = interpolate(mesh, field, pair.source, pair.target, t);
    const Signal blend = (1 - t) * pair.source + t * pair.target;
    EXPECT_LE((found - truth).norm(), 0.1 * (blend - truth).norm()) << t;
  }
}

}  // namespace
}  // namespace mq
