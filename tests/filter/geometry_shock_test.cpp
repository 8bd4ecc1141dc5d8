// Sharper shapes: edges come back, planes stay, nothing is ever infinite.

#include "mq/filter/geometry_shock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <limits>

#include "fem/handlebody.h"
#include "filter/shapes.h"
#include "mq/filter/geometry_filter.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/shapes.h"
#include "places.h"

namespace mq {
namespace {

using fixtures::error_of;
using fixtures::largest_distance;
using testing::HasSubstr;

/// The cube [-1, 1]³ with its edges rounded by smoothing.
Surface blurred_cube(int n) {
  const Surface cube = make_surface(cube_cross(n).mesh);
  Mesh mesh = cube.mesh;
  mesh.positions = filter_positions(cube, {.weight = 0.02, .beta = 0}).positions;
  return make_surface(mesh);
}

/// How sharply the surface turns: the mean angle over its edges, weighted by length · angle,
/// radians.
double sharpness(const Surface& surface, const std::vector<Vector3>& positions) {
  Mesh mesh = surface.mesh;
  mesh.positions = positions;
  const auto normals = triangle_normals(mesh);
  double sum = 0, squares = 0;
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
    if (surface.twins[h] < h) continue;
    const double angle =
        std::acos(std::clamp(normals[h / 3].dot(normals[surface.twins[h] / 3]), -1.0, 1.0));
    const double length = (mesh.position(h / 3, (h + 1) % 3) - mesh.position(h / 3, h % 3)).norm();
    sum += length * angle;
    squares += length * angle * angle;
  }
  return squares / sum;
}

/// Mean angle between the normals and the axis they are nearest to, by area, radians.
double distance_to_axes(const Surface& surface, const std::vector<Vector3>& positions) {
  Mesh mesh = surface.mesh;
  mesh.positions = positions;
  double sum = 0, total = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const double area = triangle_area(mesh, t);
    sum += area * std::acos(std::min(1.0, triangle_normal(mesh, t).cwiseAbs().maxCoeff()));
    total += area;
  }
  return sum / total;
}

TEST(GeometryShock, SharpensABlurredCube) {
  const Surface cube = blurred_cube(48);
  const double before = sharpness(cube, cube.mesh.positions);
  const double away = distance_to_axes(cube, cube.mesh.positions);
  const SharpenedShape sharp = sharpen_shape(
      cube, {.time = {ShockTime::Unit::relative, 10}, .fit_steps = 3});
  EXPECT_GT(sharpness(cube, sharp.positions), 2 * before);
  EXPECT_LT(distance_to_axes(cube, sharp.positions), 0.4 * away);
}

TEST(GeometryShock, SharpensMoreWithTime) {
  const Surface cube = blurred_cube(32);
  double before = sharpness(cube, cube.mesh.positions);
  for (const double tau : {0.2, 1.0, 5.0}) {
    const double now = sharpness(
        cube, sharpen_shape(cube, {.time = {ShockTime::Unit::relative, tau}})
                  .positions);
    EXPECT_GT(now, 1.05 * before) << tau;
    before = now;
  }
}

TEST(GeometryShock, LeavesTheShapeAloneAtTimeZero) {
  const Surface torus = make_surface(fixtures::bumpy_torus());
  for (const auto unit : {ShockTime::Unit::relative, ShockTime::Unit::absolute}) {
    const SharpenedShape same = sharpen_shape(torus, {.time = {unit, 0}, .fit_steps = 3});
    EXPECT_EQ(same.positions, torus.mesh.positions);
    EXPECT_EQ(same.normals, triangle_normals(torus.mesh));
    EXPECT_TRUE(same.solves.back().converged);
  }
}

/// Length of the edges at which the surface turns by more than 60 degrees.
double crease_length(const Surface& surface, const std::vector<Vector3>& positions) {
  Mesh mesh = surface.mesh;
  mesh.positions = positions;
  const auto normals = triangle_normals(mesh);
  double sum = 0;
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (surface.twins[h] > h && normals[h / 3].dot(normals[surface.twins[h] / 3]) < 0.5)
      sum += (mesh.position(h / 3, (h + 1) % 3) - mesh.position(h / 3, h % 3)).norm();
  return sum;
}

TEST(GeometryShock, KeepsCreasesThatAreClean) {
  // Faces of a few squares and of many, convex and concave creases, walls one square thick.
  for (const Mesh& mesh : {cube_cross(1).mesh, cube_cross(3).mesh, cube_cross(24).mesh,
                           test::handlebody(2, 1), test::handlebody(2, 2),
                           test::handlebody(1, 6)}) {
    const Surface block = make_surface(mesh);
    const double creases = crease_length(block, block.mesh.positions);
    EXPECT_GT(creases, 0);
    for (const ShockTime time :
         {ShockTime{ShockTime::Unit::relative, 1e-9}, ShockTime{ShockTime::Unit::relative, 2},
          ShockTime{ShockTime::Unit::absolute, 1e6}})
      for (const double alpha : {0.0, 1e-5, 1e-3}) {
        const SharpenedShape same = sharpen_shape(
            block,
            {.signal_alpha = alpha, .potential_alpha = alpha, .time = time, .fit_steps = 2});
        EXPECT_NEAR(crease_length(block, same.positions), creases, 1e-9 * creases)
            << mesh.vertex_count() << " " << time.value << " " << alpha;
        EXPECT_LT(largest_distance(same.positions, block.mesh.positions), 1e-9);
      }
  }
}

TEST(GeometryShock, GivesASmoothedCubeItsCreasesBack) {
  const Surface cube = make_surface(cube_cross(24).mesh), blurred = blurred_cube(24);
  const double creases = crease_length(cube, cube.mesh.positions);
  EXPECT_EQ(crease_length(blurred, blurred.mesh.positions), 0);
  const SharpenedShape sharp = sharpen_shape(
      blurred, {.time = {ShockTime::Unit::relative, 10}, .fit_steps = 10});
  EXPECT_GT(crease_length(blurred, sharp.positions), 0.6 * creases);
  EXPECT_LT(distance_to_axes(blurred, sharp.positions),
            0.2 * distance_to_axes(blurred, blurred.mesh.positions));
}

TEST(GeometryShock, KeepsAPlane) {
  const Surface flat = make_surface(fixtures::flat_square(12, 0.2));
  for (const double time : {0.0, 1.0, 1e6}) {
    const SharpenedShape same =
        sharpen_shape(flat, {.time = {ShockTime::Unit::absolute, time}, .fit_steps = 2});
    EXPECT_LT(largest_distance(same.positions, flat.mesh.positions), 1e-10) << time;
  }
}

TEST(GeometryShock, MovesWithTheShapeAndItsUnit) {
  const Mesh mesh = fixtures::bumpy_torus(30);
  for (const ShockTime time :
       {ShockTime{ShockTime::Unit::relative, 2}, ShockTime{ShockTime::Unit::absolute, 1e-3}}) {
    const GeometryShockOptions options{.time = time};
    const SharpenedShape plain = sharpen_shape(make_surface(mesh), options);
    EXPECT_GT(largest_distance(plain.positions, mesh.positions), 1e-3);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Vector3(1, 1, -2).normalized()).matrix();
    for (const double scale : {1.0, 1e-2, 1e3}) {
      Mesh moved = mesh;
      for (Vector3& p : moved.positions) p = scale * (turn * p + Vector3(1, 2, 3));
      std::vector<Vector3> wanted;
      for (const Vector3& p : plain.positions)
        wanted.push_back(scale * (turn * p + Vector3(1, 2, 3)));
      EXPECT_LT(largest_distance(sharpen_shape(make_surface(moved), options).positions, wanted),
                1e-8 * scale);
    }
  }
}

TEST(GeometryShock, IsFiniteForAnyTimeOnUglyMeshes) {
  Mesh slivers = fixtures::flat_square(4);
  for (Vector3& p : slivers.positions) p.z() = std::sin(5 * p.x() * p.y());
  slivers.triangles.push_back({0, 1, 2});
  slivers.triangles.push_back({6, 6, 7});
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  Mesh open = fixtures::sphere(3);
  open.triangles.resize(150);
  for (const Mesh& mesh :
       {slivers, open, fixtures::nonmanifold_vertex(), fixtures::nonmanifold_edge(),
        fixtures::moebius_strip(12), fixtures::one_triangle(), fixtures::tetrahedron(),
        fixtures::beside(fixtures::sphere(2), fixtures::torus(12, 8))}) {
    const Surface surface = make_surface(mesh);
    const double size = bounding_box(surface.mesh).diagonal();
    for (const double time : {1.0, 1e6, std::numeric_limits<double>::infinity()})
      for (const auto unit : {ShockTime::Unit::relative, ShockTime::Unit::absolute}) {
        const SharpenedShape result =
            sharpen_shape(surface, {.time = {unit, time}, .fit_steps = 2});
        for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
          EXPECT_TRUE(result.positions[v].allFinite());
          EXPECT_LT((result.positions[v] - surface.mesh.positions[v]).norm(), 2 * size);
          const int first = surface.vertex_from_source[surface.source_from_vertex[v]];
          EXPECT_EQ(result.positions[v], result.positions[first]);
        }
      }
  }
}

TEST(GeometryShock, ComesToARestOfPlanes) {
  // Of a blurred cube all paths end in the middles of the six faces.
  const Surface cube = blurred_cube(17);
  const SharpenedShape sharp =
      sharpen_shape(cube, {.signal_alpha = 1e-3, .potential_alpha = 1e-3,
                           .time = {ShockTime::Unit::absolute, 1e6}});
  EXPECT_EQ(sharp.counts.paths, 3 * cube.triangle_count());
  EXPECT_EQ(sharp.counts.resting, sharp.counts.paths);
  EXPECT_EQ(sharp.counts.cut_short, 0);
  int on_axes = 0;
  for (const Vector3& n : sharp.normals) on_axes += n.cwiseAbs().maxCoeff() > 1 - 1e-4;
  EXPECT_GT(on_axes, 0.9 * cube.triangle_count());
}

TEST(GeometryShock, IsTheSameForAnyNumberOfThreads) {
  const Surface cube = blurred_cube(16);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return sharpen_shape(cube, {.time = {ShockTime::Unit::relative, 3}}).positions;
  };
  const auto one = with(1);
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(7));
}

TEST(GeometryShock, SharpensScans) {
  const std::filesystem::path folder = places::data() / "C_untextured";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  // Coarse; with slivers; open, with many holes.
  for (const char* name : {"goathead.obj", "wingnut.obj", "plane_holes.obj"}) {
    const Surface scan = make_surface(read_model(folder / name).mesh);
    for (const double tau : {1.0, 1e6}) {
      const SharpenedShape sharp =
          sharpen_shape(scan, {.time = {ShockTime::Unit::relative, tau}});
      Mesh after = scan.mesh;
      after.positions = sharp.positions;
      EXPECT_LT(largest_distance(after.positions, scan.mesh.positions), 0.1 * std::sqrt(scan.area))
          << name;
      const double area = make_surface(after).area;
      EXPECT_LT(area, scan.area) << name;
      EXPECT_GT(area, 0.7 * scan.area) << name;
      EXPECT_EQ(sharp.counts.cut_short, 0);
    }
  }
}

/// P = ½(κ₁² + κ₂²): 1/r² on a sphere.
TEST(GeometryShock, HasThePotentialOfTheCurvatures) {
  Mesh mesh = fixtures::sphere(5);
  const Vector unit = sharpen_shape(make_surface(mesh), {}).potential;
  ASSERT_EQ(unit.size(), mesh.vertex_count());
  EXPECT_NEAR(unit.mean(), 1, 0.01);
  EXPECT_LT((unit.array() - 1).abs().maxCoeff(), 0.05);
  for (Vector3& p : mesh.positions) p *= 2;
  const Vector twice = sharpen_shape(make_surface(mesh), {}).potential;
  EXPECT_LT((4 * twice - unit).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(GeometryShock, RefusesWhatMeansNothing) {
  const Surface surface = make_surface(fixtures::flat_square(2));
  EXPECT_THAT(error_of([&] { sharpen_shape(surface, {.normal_alpha = -1}); }),
              HasSubstr("normals"));
  EXPECT_THAT(error_of([&] { sharpen_shape(surface, {.potential_alpha = NAN}); }),
              HasSubstr("potential"));
  EXPECT_THAT(error_of([&] {
                sharpen_shape(surface, {.time = {ShockTime::Unit::relative, -1}});
              }),
              HasSubstr("time"));
}

}  // namespace
}  // namespace mq
