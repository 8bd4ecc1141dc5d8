// Fitting vertices to normals: what has its normals stays, what can have them gets them.

#include "mq/filter/normal_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "filter/shapes.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using fixtures::error_of;
using fixtures::largest_distance;
using testing::HasSubstr;

Surface bumpy(int n = 30) { return make_surface(fixtures::bumpy_torus(n)); }

/// Some normal field that is not the surface's.
std::vector<Vector3> other_normals(const Mesh& mesh) {
  std::vector<Vector3> normals = triangle_normals(mesh);
  for (std::size_t t = 0; t < normals.size(); ++t)
    normals[t] = (normals[t] + 0.3 * Vector3(std::sin(3.0 * normals[t].x()), normals[t].z(), 0.2))
                     .normalized();
  return normals;
}

TEST(NormalFit, KeepsAShapeThatHasTheNormals) {
  for (const Surface& surface : {bumpy(), make_surface(fixtures::sphere(3)),
                                 make_surface(fixtures::flat_square(9, 0.2))}) {
    const NormalFit fit(surface);
    std::vector<Vector3> normals = triangle_normals(surface.mesh);
    for (const int steps : {1, 3})
      EXPECT_TRUE(fit.fit(normals, steps).positions == surface.mesh.positions);
    // The same normals but for their last bits.
    for (Vector3& n : normals) n *= 0.3;
    for (const int steps : {1, 3})
      EXPECT_LT(largest_distance(fit.fit(normals, steps).positions, surface.mesh.positions), 1e-10);
  }
}

TEST(NormalFit, TakesNormalsOfEitherSignAndAnyLength) {
  const Surface surface = bumpy();
  std::vector<Vector3> normals = other_normals(surface.mesh);
  const NormalFit fit(surface);
  const Reshaped once = fit.fit(normals);
  for (std::size_t t = 0; t < normals.size(); ++t) normals[t] *= t % 2 == 0 ? -7 : 0.01;
  EXPECT_LT(largest_distance(fit.fit(normals).positions, once.positions), 1e-12);
}

/// Unit means of normals at the corners.
std::vector<Vector3> means(const Mesh& mesh, const std::vector<Vector3>& normals) {
  std::vector<Vector3> result;
  for (const Triangle& t : mesh.triangles)
    result.push_back((normals[t[0]] + normals[t[1]] + normals[t[2]]).normalized());
  return result;
}

TEST(NormalFit, KeepsAPlaneUnderItsNormalsAtVertices) {
  const Surface surface = make_surface(fixtures::flat_square(12, 0.2));
  const auto normals = means(surface.mesh, vertex_normals(surface.mesh));
  EXPECT_LT(largest_distance(NormalFit(surface).fit(normals).positions, surface.mesh.positions),
            1e-12);
}

TEST(NormalFit, KeepsASphereUnderItsNormalsAtVerticesToSecondOrder) {
  double before = 0;
  for (const int levels : {3, 4, 5}) {
    const Surface surface = make_surface(fixtures::sphere(levels));
    const auto normals = means(surface.mesh, surface.mesh.positions);
    const double moved =
        largest_distance(NormalFit(surface).fit(normals).positions, surface.mesh.positions);
    if (before > 0) {
      EXPECT_GT(std::log2(before / moved), 1.7) << levels;
    }
    before = moved;
  }
  EXPECT_LT(before, 0.01);
}

TEST(NormalFit, TiltsAPlane) {
  // (I − nnᵀ) p about the middle: the shadow of the square on the plane asked for.
  const Surface surface = make_surface(fixtures::flat_square(8, 0.2));
  const Vector3 n = Vector3(0.3, -0.2, 1).normalized(), middle(0.5, 0.5, 0);
  const std::vector<Vector3> normals(surface.mesh.triangles.size(), n);
  const NormalFit fit(surface, 1e6);
  for (const int steps : {1, 4}) {
    const Reshaped tilted = fit.fit(normals, steps);
    for (std::size_t v = 0; v < tilted.positions.size(); ++v) {
      const Vector3 arm = surface.mesh.positions[v] - middle;
      EXPECT_LT((tilted.positions[v] - middle - (arm - arm.dot(n) * n)).norm(), 1e-5);
    }
  }
}

TEST(NormalFit, FoldsARoofFromItsNormals) {
  // The normals (∓sin a, 0, cos a) of a roof with its ridge at x = ½ can be had exactly:
  // x' = cos²a (x − ½), z' = −sin a cos a |x − ½| + mean.
  const Surface surface = make_surface(fixtures::flat_square(16));
  const double a = 0.4;
  std::vector<Vector3> normals;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const double x = (surface.mesh.position(t, 0).x() + surface.mesh.position(t, 1).x() +
                      surface.mesh.position(t, 2).x()) / 3;
    normals.emplace_back((x < 0.5 ? -1 : 1) * std::sin(a), 0, std::cos(a));
  }
  const Reshaped roof = NormalFit(surface, 1e6).fit(normals);
  for (std::size_t v = 0; v < roof.positions.size(); ++v) {
    const Vector3& p = surface.mesh.positions[v];
    const double x = std::cos(a) * std::cos(a) * (p.x() - 0.5) + 0.5;
    const double z = std::sin(a) * std::cos(a) * (0.25 - std::abs(p.x() - 0.5));
    EXPECT_LT((roof.positions[v] - Vector3(x, p.y(), z)).norm(), 1e-5);
  }
}

TEST(NormalFit, ComesNearerToTheNormalsWithMoreSteps) {
  const Surface surface = make_surface(fixtures::sphere(4));
  // A ball seen as a cube: the normal of the nearest face.
  std::vector<Vector3> normals;
  for (const Vector3& n : triangle_normals(surface.mesh)) {
    int axis;
    n.cwiseAbs().maxCoeff(&axis);
    normals.push_back(n[axis] > 0 ? Vector3(Vector3::Unit(axis)) : Vector3(-Vector3::Unit(axis)));
  }
  const NormalFit fit(surface);
  const auto error = [&](int steps) {
    Mesh mesh = surface.mesh;
    mesh.positions = fit.fit(normals, steps).positions;
    const auto now = triangle_normals(mesh);
    double sum = 0;
    for (std::size_t t = 0; t < now.size(); ++t) sum += std::acos(std::abs(now[t].dot(normals[t])));
    return sum / double(now.size());
  };
  const double once = error(1), often = error(8);
  EXPECT_LT(once, 0.25);
  EXPECT_LT(often, 0.7 * once);
}

TEST(NormalFit, NeverMakesTheAreaLarger) {
  // ½ ∫ |∇p|² is at least the area, equal for p₀, and a projection of gradients makes it no larger.
  for (const Surface& surface : {bumpy(), make_surface(fixtures::sphere(3))}) {
    const NormalFit fit(surface, 1e4);
    std::vector<Vector3> wild = triangle_normals(surface.mesh);
    for (std::size_t t = 0; t < wild.size(); ++t)
      wild[t] = Vector3(std::sin(double(t)), std::sin(2.0 * double(t)), std::cos(3.0 * double(t)));
    for (const std::vector<Vector3>& normals : {wild, other_normals(surface.mesh)}) {
      Mesh mesh = surface.mesh;
      double before = surface.area * (1 + 1e-4);
      for (const int steps : {1, 2, 5}) {
        mesh.positions = fit.fit(normals, steps).positions;
        const double area = make_surface(mesh).area;
        EXPECT_LE(area, before);
        before = area * (1 + 1e-4);
      }
    }
  }
}

TEST(NormalFit, MovesWithTheShape) {
  const Surface surface = bumpy();
  const std::vector<Vector3> normals = other_normals(surface.mesh);
  const Reshaped plain = NormalFit(surface).fit(normals, 2);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).matrix();
  for (const double scale : {1.0, 1e-3, 1e4}) {
    const Vector3 shift = scale * Vector3(3, -1, 2);
    Mesh moved = surface.mesh;
    for (Vector3& p : moved.positions) p = scale * (turn * p) + shift;
    std::vector<Vector3> turned;
    for (const Vector3& n : normals) turned.push_back(turn * n);
    std::vector<Vector3> wanted;
    for (const Vector3& p : plain.positions) wanted.push_back(scale * (turn * p) + shift);
    const Reshaped result = NormalFit(make_surface(moved)).fit(turned, 2);
    EXPECT_LT(largest_distance(result.positions, wanted), 1e-10 * scale);
  }
}

TEST(NormalFit, IsTheSameForAnyNumberOfThreads) {
  const Surface surface = bumpy(60);
  const std::vector<Vector3> normals = other_normals(surface.mesh);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return NormalFit(surface).fit(normals, 2).positions;
  };
  const auto one = with(1);
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(7));
}

TEST(NormalFit, CopesWithUglyMeshes) {
  Mesh slivers = fixtures::flat_square(4);
  slivers.triangles.push_back({0, 1, 2});        // collinear
  slivers.triangles.push_back({6, 6, 7});        // two equal vertices
  slivers.positions.emplace_back(9, 9, 9);       // used by none
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  for (const Mesh& mesh : {slivers, fixtures::nonmanifold_vertex(), fixtures::nonmanifold_edge(),
                           fixtures::moebius_strip(12), fixtures::one_triangle(),
                           fixtures::beside(fixtures::sphere(1), fixtures::flat_square(2))}) {
    const Surface surface = make_surface(mesh);
    std::vector<Vector3> normals = triangle_normals(surface.mesh);
    for (Vector3& n : normals) n += Vector3(0.2, 0.3, -0.1);
    normals[0].setZero();
    const NormalFit fit(surface);
    const Reshaped result = fit.fit(normals, 3);
    for (const Vector3& p : result.positions) EXPECT_TRUE(p.allFinite());
    EXPECT_LT(largest_distance(fit.fit(triangle_normals(surface.mesh)).positions,
                               surface.mesh.positions),
              1e-10);
    // What was one vertex in the file is one again.
    for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
      const int first = surface.vertex_from_source[surface.source_from_vertex[v]];
      EXPECT_EQ(result.positions[v], result.positions[first]);
    }
  }
}

TEST(NormalFit, KeepsTheCentreOfEachComponent) {
  Mesh far = fixtures::sphere(2);
  for (Vector3& p : far.positions) p = 0.1 * p + Vector3(5, 0, 0);
  const Surface surface = make_surface(fixtures::beside(fixtures::sphere(3), far));
  const int first = fixtures::sphere(3).vertex_count();
  const Reshaped result = NormalFit(surface).fit(other_normals(surface.mesh));
  const Vector mass = VertexSpace(surface).mass() * Vector::Ones(surface.mesh.vertex_count());
  Vector3 moved[2] = {Vector3::Zero(), Vector3::Zero()};
  for (int v = 0; v < surface.mesh.vertex_count(); ++v)
    moved[v < first ? 0 : 1] += mass[v] * (result.positions[v] - surface.mesh.positions[v]);
  EXPECT_LT(moved[0].norm(), 1e-10);
  EXPECT_LT(moved[1].norm(), 1e-12);
}

TEST(FilteredWith, LeavesNormalsAloneWhereNothingChanges) {
  const Surface surface = bumpy();
  const VertexSpace space(surface);
  const std::vector<Vector3> own = triangle_normals(surface.mesh), at = vertex_normals(surface.mesh);
  EXPECT_TRUE(filtered_with(space, own, {at, at, 0.01, 1}) == own);
  EXPECT_TRUE(filtered_with(space, own, {at, at, 0, 0}) == own);
  // A reach far below a triangle's size changes next to nothing.
  EXPECT_LT(largest_distance(filtered_with(space, own, {at, at, 1e-12, 0}), own), 1e-7);
}

TEST(FilteredWith, FadesWhatVerticesCannotHoldAsAWaveOfATrianglesSize) {
  // Equilateral, side 1: λ = 24. Own normal +z, before and after the same mean m:
  // n' ∝ m + g·(z − m).
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}};
  mesh.triangles = {{0, 1, 2}};
  const Surface surface = make_surface(mesh);
  const VertexSpace space(surface);
  const Vector3 tilted = Vector3(0.5, 0, 1).normalized(), z(0, 0, 1);
  const std::vector<Vector3> at(3, tilted);
  for (const double weight : {0.01, 1.0, 1e9, std::numeric_limits<double>::infinity()})
    for (const double beta : {0.0, 3.0}) {
      const double g = std::isfinite(weight) ? (1 + beta * weight * 24) / (1 + weight * 24) : beta;
      const Vector3 wanted = (tilted + g * (z - tilted)).normalized();
      EXPECT_LT((filtered_with(space, {z}, {at, at, weight, beta})[0] - wanted).norm(), 1e-14);
    }
  // What cancels says nothing.
  const std::vector<Vector3> star = {{1, 0, 0}, {-0.5, std::sqrt(0.75), 0}, {-0.5, -std::sqrt(0.75), 0}};
  EXPECT_EQ(filtered_with(space, {z}, {star, star, 1e30, 0})[0], z);
}

TEST(NormalFit, SaysWhatDoesNotFit) {
  const Surface surface = make_surface(fixtures::flat_square(2));
  const NormalFit fit(surface);
  std::vector<Vector3> normals(8, Vector3(0, 0, 1));
  EXPECT_THAT(error_of([&] { fit.fit(std::vector<Vector3>(7)); }), HasSubstr("7 normals"));
  EXPECT_THAT(error_of([&] { fit.fit(normals, 0); }), HasSubstr("at least one step"));
  normals[3].x() = NAN;
  EXPECT_THAT(error_of([&] { fit.fit(normals); }), HasSubstr("triangle 3"));
  EXPECT_THAT(error_of([&] { NormalFit(surface, -1); }), HasSubstr("weight"));
  const VertexSpace space(surface);
  EXPECT_THAT(error_of([&] { filtered_with(space, normals, {normals, normals, 1, 0}); }),
              HasSubstr("9 vertices"));
}

}  // namespace
}  // namespace mq
