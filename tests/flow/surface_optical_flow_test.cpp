#include "mq/flow/surface_optical_flow.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <Eigen/Geometry>

#include "flow/moved_signals.h"
#include "mq/base/error.h"
#include "mq/fem/flat_triangle.h"
#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_systems.h"
#include "mq/sample/noise.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

using namespace fixtures;

TEST(MeshFlow, FindsRotationsOfTheTorus) {
  for (const auto& [shift, n] : {std::pair{1.0, 90}, {3.0, 90}, {8.0, 90}, {20.0, 180}}) {
    const Pair pair = turned_torus(shift, n);
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, from(20));
    const double angle = shift * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (n * (n / 2)));
    EXPECT_LE(end_point_error(pair, flow.field, rotation(-angle, Vector3::UnitZ())), 0.1) << shift;
    EXPECT_LE(flow.errors().back(), 0.02 * flow.blend_error) << shift;
  }
}

TEST(MeshFlow, FindsRotationsOfTheSphere) {
  const double angle = 0.25;
  const Pair pair = turned_sphere(angle);
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, from(20));
  const Vector3 axis = Vector3(0.2, 0.3, 1).normalized();
  EXPECT_LE(end_point_error(pair, flow.field, rotation(-angle, axis)), 0.1);
  EXPECT_LE(flow.errors().back(), 0.05 * flow.blend_error);
}

/// All bases but that of gradients, which has no harmonic fields, on the torus; all on the sphere.
TEST(MeshFlow, FindsThemInEveryBasisByFactorisation) {
  for (const FlowBasis basis : bases) {
    const bool sphere = basis == FlowBasis::gradient;
    const double angle = 0.15;
    const Pair pair = sphere ? moved(fixtures::sphere(5), 2, rotation(angle, Vector3::UnitZ()))
                             : moved(fixtures::torus(64, 30), 2, rotation(angle, Vector3::UnitZ()));
    MeshFlowOptions options = from(12);
    options.basis = basis;
    options.solver = FlowSolver::direct;
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
    EXPECT_LE(end_point_error(pair, flow.field, rotation(-angle, Vector3::UnitZ())), 0.1)
        << int(basis);
    EXPECT_LE(flow.errors().back(), 0.05 * flow.blend_error) << int(basis);
  }
}

/// Of a shifted square the mean distance of X from the shift, well inside, in spacings.
double error_inside(const Pair& pair, const Vector& field, const Vector3& shift) {
  const std::vector<Vector3> X = field_in_space(pair.surface, field);
  double sum = 0;
  int inside = 0;
  for (int t = 0; t < pair.surface.triangle_count(); ++t) {
    const Vector3 p = pair.surface.mesh.position(t, 0) - Vector3(0.5, 0.5, 0);
    if (p.cwiseAbs().maxCoeff() > 0.35) continue;
    sum += (X[t] - shift).norm();
    ++inside;
  }
  return sum / inside / pair.spacing;
}

TEST(MeshFlow, FindsAShiftOfThePlaneInside) {
  const Vector3 shift(0.08, 0.03, 0);
  Mesh mesh = fixtures::flat_square(60, 0.2);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Pair pair = moved(mesh, 6, [&](const Vector3& p) { return Vector3(p - shift); });
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, from(12));
  EXPECT_LE(error_inside(pair, flow.field, shift), 0.1);
}

/// Gradients are tangent to a boundary there, so the shift has to turn beside it.
TEST(MeshFlow, FindsAShiftOfThePlaneInTheGradientBasisToo) {
  const Vector3 shift(0.03, 0.01, 0);
  Mesh mesh = fixtures::flat_square(40, 0.2);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Pair pair = moved(mesh, 6, [&](const Vector3& p) { return Vector3(p - shift); });
  MeshFlowOptions options = from(6);
  options.basis = FlowBasis::gradient;
  options.solver = FlowSolver::direct;
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
  EXPECT_LE(error_inside(pair, flow.field, shift), 0.15);
  EXPECT_LE(flow.errors().back(), 0.1 * flow.blend_error);
}

/// Three vertices almost on an edge, as scans have them.
TEST(MeshFlow, IsNotHeldUpBySlivers) {
  Mesh mesh = fixtures::torus(64, 30);
  for (const int t : {100, 1500, 3000}) {
    const Triangle v = mesh.triangles[t];
    const int middle = mesh.vertex_count();
    mesh.positions.push_back(0.5 * mesh.positions[v[0]] + (0.5 - 1e-6) * mesh.positions[v[1]] +
                             1e-6 * mesh.positions[v[2]]);
    mesh.triangles[t] = {v[0], v[1], middle};
    mesh.triangles.push_back({v[1], v[2], middle});
    mesh.triangles.push_back({v[2], v[0], middle});
  }
  const Pair pair = moved(mesh, 2, rotation(0.15, Vector3::UnitZ()));
  for (const FlowBasis basis : bases) {
    if (basis == FlowBasis::gradient) continue;  // no harmonic fields
    MeshFlowOptions options = from(12);
    options.basis = basis;
    options.solver = FlowSolver::direct;
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
    EXPECT_LE(flow.errors().back(), 0.05 * flow.blend_error) << int(basis);
  }
}

/// Two triangles apart from the rest, with a difference of light over hardly any slope.
TEST(MeshFlow, MovesNoPieceFurtherThanItsSize) {
  Mesh mesh = fixtures::torus(40, 20);
  const int first = mesh.vertex_count();
  mesh.positions.insert(mesh.positions.end(), {{3, 0, 0}, {3.1, 0, 0}, {3.1, 0.1, 0}, {3, 0.1, 0}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  Pair pair = moved(mesh, 2, rotation(0.1, Vector3::UnitZ()));
  for (int v = 0; v < 4; ++v) {
    pair.source.row(first + v).setConstant(1e-3 * mesh.positions[first + v].x());
    pair.target.row(first + v).setConstant(1e-3 * mesh.positions[first + v].x() + 0.5);
  }
  for (const FlowBasis basis : {FlowBasis::vertex, FlowBasis::triangle}) {
    MeshFlowOptions options = from(10);
    options.basis = basis;
    if (basis != FlowBasis::vertex) options.solver = FlowSolver::direct;
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
    EXPECT_LE(flow.field.tail(4).cwiseAbs().maxCoeff(), 0.3) << int(basis);
    EXPECT_LE(flow.errors().back(), 0.2 * flow.blend_error) << int(basis);
  }
}

/// Gradients cannot turn a torus, but a sphere.
TEST(MeshFlow, FindsMotionsOverCoarserMeshesInEveryBasis) {
  const double angle = 20 * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (180 * 90));
  const Pair sphere = turned_sphere(0.3), torus = turned_torus(20, 180);
  for (const FlowBasis basis : bases) {
    const Pair& pair = basis == FlowBasis::gradient ? sphere : torus;
    MeshFlowOptions options = from(20);
    options.basis = basis;
    const MeshFlow coarse = mesh_flow(pair.surface, pair.source, pair.target, options);
    EXPECT_LT(coarse.levels.front().vertices, pair.source.rows() / 2) << int(basis);
    EXPECT_EQ(coarse.levels.back().vertices, pair.source.rows()) << int(basis);
    EXPECT_LE(coarse.errors().back(), 0.005 * coarse.blend_error) << int(basis);
    const Motion truth = basis == FlowBasis::gradient ? rotation(-0.3, Vector3(0.2, 0.3, 1))
                                                      : rotation(-angle, Vector3::UnitZ());
    EXPECT_LE(end_point_error(pair, coarse.field, truth), basis == FlowBasis::gradient ? 0.3 : 0.1) << int(basis);
  }
}

TEST(MeshFlow, RefusesTheWeightsOfTheThesisOnCoarserMeshes) {
  const Pair pair = turned_sphere(0.1);
  MeshFlowOptions options = thesis_flow(FlowBasis::whitney);
  options.solver = FlowSolver::hierarchical;
  EXPECT_THROW(mesh_flow(pair.surface, pair.source, pair.target, options), Unsupported);
}

TEST(MeshFlow, NeverRaisesTheError) {
  const Pair pair = turned_torus(12);  // far more than the levels below can see
  for (const double percent : {3.0, 6.0, 20.0}) {
    const std::vector<double> errors =
        mesh_flow(pair.surface, pair.source, pair.target, from(percent)).errors();
    for (std::size_t l = 1; l < errors.size(); ++l) EXPECT_LE(errors[l], errors[l - 1]);
  }
}

/// Errors of coarser levels are taken at fewer places, but no level's is said to be below what is
/// left in the end.
TEST(MeshFlow, EstimatesTheErrorOfCoarserLevels) {
  const Pair pair = turned_torus(4, 160);
  MeshFlowOptions options = from(20);
  const MeshFlow whole = mesh_flow(pair.surface, pair.source, pair.target, options);
  options.probes = 1000;
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
  EXPECT_EQ(flow.field, whole.field);
  EXPECT_EQ(flow.levels.back().error, whole.levels.back().error);
  ASSERT_EQ(flow.levels.size(), whole.levels.size());
  EXPECT_NE(flow.levels[0].error, whole.levels[0].error);
  EXPECT_LT(flow.levels[0].vertices, pair.source.rows());
  double before = flow.blend_error;
  for (std::size_t l = 0; l < flow.levels.size(); ++l) {
    EXPECT_NEAR(flow.levels[l].error, whole.levels[l].error,
                0.1 * whole.levels[l].error + 0.005 * flow.blend_error);
    EXPECT_LE(flow.levels[l].error, before);
    before = flow.levels[l].error;
  }
  // Nothing to align: what coarse levels find counts only if it holds on the mesh itself.
  const Noise noise(3);
  Signal other = pair.target;
  for (int v = 0; v < other.rows(); ++v)
    other.row(v).setConstant(noise(9 * pair.surface.mesh.positions[v]));
  options.levels = 2;
  const MeshFlow none = mesh_flow(pair.surface, pair.source, other, options);
  EXPECT_LT(none.levels.back().vertices, pair.source.rows());
  EXPECT_LE(none.levels.back().error, none.blend_error);
}

/// (4.8): smoothness shortens a field, never lengthens it.
TEST(MeshFlow, ScalesCorrectionsUp) {
  const Pair pair = turned_torus(3);
  for (const FlowBasis basis : bases)
    for (const MeshFlowLevel& level :
         mesh_flow(pair.surface, pair.source, pair.target, thesis_flow(basis)).levels)
      EXPECT_GE(level.scale, 1 - 1e-9) << int(basis);
  for (const MeshFlowLevel& level :
       mesh_flow(pair.surface, pair.source, pair.target, from(20)).levels) {
    EXPECT_GE(level.steps, 1);
    EXPECT_GE(level.scale, 1 - 1e-3);  // of systems solved by multigrid to 10⁻³
  }
}

TEST(MeshFlow, OfTheThesisLowersTheErrorToo) {
  const Pair pair = turned_torus(3);
  for (const FlowBasis basis : {FlowBasis::vertex, FlowBasis::triangle, FlowBasis::whitney}) {
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, thesis_flow(basis));
    EXPECT_EQ(flow.levels.size(), 7u);
    EXPECT_LE(flow.levels.back().error, 0.3 * flow.blend_error) << int(basis);
  }
}

TEST(MeshFlow, TurnsAroundWhenSignalsAreSwapped) {
  const Pair pair = turned_torus(3, 60);
  for (const FlowSolver solver : {FlowSolver::hierarchical, FlowSolver::direct}) {
    MeshFlowOptions options = from(15);
    options.solver = solver;
    const Vector there = mesh_flow(pair.surface, pair.source, pair.target, options).field;
    const Vector back = mesh_flow(pair.surface, pair.target, pair.source, options).field;
    EXPECT_LE((there + back).cwiseAbs().maxCoeff(), 1e-10 * there.cwiseAbs().maxCoeff());
  }
}

TEST(MeshFlow, DoesNotSeeTheUnitOfTheModelNorOfTheValues) {
  const Pair pair = turned_torus(3, 60);
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, from(15));
  EXPECT_GT(flow.field.cwiseAbs().maxCoeff(), 0);
  for (const double unit : {1024.0, 1000.0, 0.0254, 1e-30, 1e30}) {
    Mesh scaled = pair.surface.mesh;
    for (Vector3& p : scaled.positions) p *= unit;
    const MeshFlow same = mesh_flow(make_surface(scaled), pair.source, pair.target, from(15));
    EXPECT_LE((same.field / unit - flow.field).cwiseAbs().maxCoeff(),
              1e-9 * flow.field.cwiseAbs().maxCoeff())
        << unit;
  }
  for (const double factor : {256.0, 0.3}) {
    const MeshFlow bright =
        mesh_flow(pair.surface, factor * pair.source, factor * pair.target, from(15));
    EXPECT_LE((bright.field - flow.field).cwiseAbs().maxCoeff(),
              1e-9 * flow.field.cwiseAbs().maxCoeff())
        << factor;
  }
}

TEST(MeshFlow, MeansTheSameAtAnyResolution) {
  const auto shift = [&](int n) {
    const Pair pair = moved(fixtures::torus(n, n / 2), 1.5, rotation(0.2, Vector3::UnitZ()));
    MeshFlowOptions options = from(15);
    options.levels = 2;
    options.solver = FlowSolver::direct;
    options.steps = 1;
    const Vector field = mesh_flow(pair.surface, pair.source, pair.target, options).field;
    const auto X = field_in_space(pair.surface, field);
    // How far it turns around the axis, on average.
    double sum = 0, all = 0;
    for (int t = 0; t < pair.surface.triangle_count(); ++t) {
      const Vector3 along = around_z(pair.surface.mesh.position(t, 0));
      sum += X[t].dot(along) / along.squaredNorm();
      all += 1;
    }
    return sum / all;
  };
  EXPECT_NEAR(shift(64), shift(128), 0.02 * shift(128));
}

TEST(MeshFlow, OfEqualSignalsIsZero) {
  const Pair pair = turned_torus(3, 40);
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.source);
  EXPECT_EQ(flow.field.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(flow.blend_error, 0);
  const Signal constant = Signal::Constant(pair.source.rows(), 1, 0.5);
  const MeshFlow nothing = mesh_flow(pair.surface, constant, constant);
  EXPECT_EQ(nothing.field.cwiseAbs().maxCoeff(), 0);
}

/// Light that changes slowly over the surface is left out.
TEST(MeshFlow, LeavesLightOut) {
  Pair pair = turned_torus(3);
  for (int v = 0; v < pair.target.rows(); ++v)
    pair.target.row(v).array() += 0.6 * pair.surface.mesh.positions[v].x();
  MeshFlowOptions options = from(15);
  const double angle = 3 * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (90 * 45));
  const auto error = [&] {
    return end_point_error(pair, mesh_flow(pair.surface, pair.source, pair.target, options).field,
                           rotation(-angle, Vector3::UnitZ()));
  };
  const double lit = error();
  options.detail = {8, Length::Unit::percent};
  EXPECT_LE(error(), 0.5 * lit);
}

/// The same light, not left out beforehand: slopes do not see it.
TEST(MeshFlow, FollowsSlopesThroughChangingLight) {
  Pair pair = turned_torus(3);
  for (int v = 0; v < pair.target.rows(); ++v)
    pair.target.row(v).array() += 0.1 * pair.surface.mesh.positions[v].x();
  MeshFlowOptions options = from(15);
  const double angle = 3 * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (90 * 45));
  const auto error = [&] {
    return end_point_error(pair, mesh_flow(pair.surface, pair.source, pair.target, options).field,
                           rotation(-angle, Vector3::UnitZ()));
  };
  const double lit = error();
  options.gradient_weight = 5;
  EXPECT_LE(error(), 0.2 * lit);
}

/// A tenth of the surface shows something else altogether: squares follow it farther than ψ does.
TEST(MeshFlow, IsRobustWhenAsked) {
  Pair pair = turned_torus(3);
  const Noise noise(99);
  for (int v = 0; v < pair.target.rows(); ++v)
    if (pair.surface.mesh.positions[v].x() > 0.95)
      pair.target.row(v).setConstant(noise(5 * pair.surface.mesh.positions[v]));
  const double angle = 3 * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (90 * 45));
  const auto error = [&](double robust_data) {
    MeshFlowOptions options = from(15);
    options.robust_data = robust_data;
    return end_point_error(pair, mesh_flow(pair.surface, pair.source, pair.target, options).field,
                           rotation(-angle, Vector3::UnitZ()));
  };
  EXPECT_LT(error(0.2), 0.8 * error(0));
}

TEST(MeshFlow, ForwardFindsTheSameMotion) {
  const Pair pair = turned_torus(3);
  MeshFlowOptions options = from(15);
  options.alignment = FlowAlignment::forward;
  const double angle = 3 * std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (90 * 45));
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
  EXPECT_LE(end_point_error(pair, flow.field, rotation(-angle, Vector3::UnitZ())), 0.15);
}

TEST(MeshFlow, GivesTheSameBitsForAnyNumberOfThreads) {
  const Pair pair = turned_torus(3, 60);
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return mesh_flow(pair.surface, pair.source, pair.target, from(15)).field;
  };
  const Vector one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(7), one);
}

TEST(MeshFlow, CopesWithUglySurfaces) {
  Mesh mesh = fixtures::beside(fixtures::torus(30, 16), fixtures::nonmanifold_edge());
  mesh.positions.insert(mesh.positions.end(), {{2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {9, 9, 9}});
  mesh.triangles.push_back(
      {mesh.vertex_count() - 4, mesh.vertex_count() - 3, mesh.vertex_count() - 2});
  const Surface surface = make_surface(mesh);
  Signal a(surface.mesh.vertex_count(), 1), b = a;
  for (int v = 0; v < a.rows(); ++v) {
    a(v, 0) = std::sin(5 * surface.mesh.positions[v].x());
    b(v, 0) = std::sin(5 * surface.mesh.positions[v].x() + 0.3);
  }
  const MeshFlow flow = mesh_flow(surface, a, b, from(10));
  EXPECT_TRUE(flow.field.allFinite());
  EXPECT_LT(flow.errors().back(), 0.3 * flow.blend_error);
  // Vertices that only a triangle without area uses leave no row empty.
  for (const FlowBasis basis : bases) {
    MeshFlowOptions options = from(10);
    options.basis = basis;
    options.solver = FlowSolver::direct;
    const MeshFlow direct = mesh_flow(surface, a, b, options);
    EXPECT_TRUE(direct.field.allFinite()) << int(basis);
    EXPECT_LE(direct.errors().back(), direct.blend_error) << int(basis);
  }
}

TEST(MeshFlow, RefusesWhatItCannotAlign) {
  const Pair pair = turned_torus(1, 20);
  EXPECT_THROW(mesh_flow(pair.surface, pair.source, pair.target.leftCols(1)), InvalidInput);
  Signal broken = pair.target;
  broken(17, 1) = std::nan("");
  EXPECT_NE(
      fixtures::error_of([&] { mesh_flow(pair.surface, pair.source, broken); }).find("vertex 17"),
      std::string::npos);
  MeshFlowOptions options;
  options.largest = {-1, Length::Unit::model};
  EXPECT_THROW(mesh_flow(pair.surface, pair.source, pair.target, options), InvalidInput);
  options = from(2);
  options.smallest = {5, Length::Unit::percent};
  EXPECT_THROW(mesh_flow(pair.surface, pair.source, pair.target, options), InvalidInput);
  options = {};
  options.robust_data = -1;
  EXPECT_THROW(mesh_flow(pair.surface, pair.source, pair.target, options), InvalidInput);
}

}  // namespace
}  // namespace mq
