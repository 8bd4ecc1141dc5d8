// Smoothing and sharpening of shapes: what stays, what shrinks by how much, and where creases stay.

#include "mq/filter/geometry_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "filter/shapes.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

using fixtures::error_of;
using fixtures::largest_distance;
using testing::HasSubstr;

/// By how much positions of a filtered unit sphere of 4·4^levels triangles miss gain times theirs,
/// root mean square.
double error_of_gain(int levels, const GeometryFilterOptions& options, double gain) {
  const Surface sphere = make_surface(fixtures::sphere(levels));
  const Reshaped result = filter_positions(sphere, options);
  double sum = 0;
  for (std::size_t v = 0; v < result.positions.size(); ++v)
    sum += (result.positions[v] - gain * sphere.mesh.positions[v]).squaredNorm();
  return std::sqrt(sum / double(result.positions.size()));
}

TEST(FilterPositions, WorksWhereTheMaskSays) {
  const Surface torus = make_surface(fixtures::bumpy_torus(60));
  GeometryFilterOptions options{.weight = 1e-3, .beta = 0};
  const auto everywhere = filter_positions(torus, options).positions;
  const std::size_t count = everywhere.size();
  options.mask.assign(count, 1);
  EXPECT_EQ(filter_positions(torus, options).positions, everywhere);
  options.mask.assign(count, 0);
  EXPECT_EQ(filter_positions(torus, options).positions, torus.mesh.positions);
  // On one side of the torus: as everywhere there, next to nothing on the other.
  for (std::size_t v = 0; v < count; ++v) options.mask[v] = torus.mesh.positions[v].x() > 0;
  const auto half = filter_positions(torus, options).positions;
  for (std::size_t v = 0; v < count; ++v) {
    // Within 25 lengths the difference has faded.
    const Vector3& p = torus.mesh.positions[v];
    if (p.x() > 0.8) {
      EXPECT_LT((half[v] - everywhere[v]).norm(), 1e-4) << v;
    }
    if (p.x() < -0.8) {
      EXPECT_LT((half[v] - p).norm(), 1e-4) << v;
    }
  }
  EXPECT_GT(largest_distance(half, torus.mesh.positions), 3e-3);
  options.mask.pop_back();
  EXPECT_THAT(error_of([&] { filter_positions(torus, options); }), HasSubstr("a mask of"));
}

TEST(FilterPositions, ChangesNothingAtBetaOne) {
  const Surface surface = make_surface(fixtures::torus(20, 10));
  for (const double crease : {0.0, 0.3}) {
    const Reshaped same =
        filter_positions(surface, {.weight = 0.1, .beta = 1, .crease_length = crease});
    EXPECT_TRUE(same.positions == surface.mesh.positions);
  }
}

TEST(FilterPositions, HasTheGainOfASphereToSecondOrder) {
  // Coordinates on the unit sphere have the eigenvalue 2.
  const double w = 0.05;
  for (const double beta : {0.0, 3.0}) {
    const double gain = (1 + beta * w * 2) / (1 + w * 2);
    const GeometryFilterOptions options{.weight = w, .beta = beta};
    const double coarse = error_of_gain(4, options, gain), fine = error_of_gain(5, options, gain);
    EXPECT_LT(fine, 1e-3);
    EXPECT_GT(std::log2(coarse / fine), 1.8);
  }
}

TEST(FilterPositions, ShrinksASphereLessInTheMetricOfItsCreases) {
  // On the unit sphere the metric is (1 + ℓ²) times the surface's, λ that much smaller.
  const double w = 0.05, crease = 2;
  const double gain = 1 / (1 + w * 2 / (1 + crease * crease));
  EXPECT_LT(error_of_gain(
                5, {.weight = w, .beta = 0, .crease_length = crease, .crease_alpha = 0}, gain),
            0.05 * (1 - gain));
}

TEST(FilterPositions, RoundsACubeLessWhenCreasesAreFarToCross) {
  const Surface surface = make_surface(cube_cross(16).mesh);
  const auto rounded = [&](double crease) {
    return largest_distance(
        filter_positions(surface, {.weight = 0.02, .beta = 0, .crease_length = crease}).positions,
        surface.mesh.positions);
  };
  EXPECT_LT(rounded(2), 0.5 * rounded(0));
}

TEST(FilterPositions, MovesWithTheShapeAndItsUnit) {
  const Surface surface = make_surface(fixtures::torus(24, 12));
  const GeometryFilterOptions options{.weight = 0.01, .beta = 4, .crease_length = 0.2};
  const Reshaped plain = filter_positions(surface, options);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3(1, -2, 1).normalized()).matrix();
  const double scale = 1e3;
  Mesh moved = surface.mesh;
  for (Vector3& p : moved.positions) p = scale * (turn * p) + Vector3(1, 2, 3);
  const Reshaped result = filter_positions(
      make_surface(moved),
      {.weight = 0.01 * scale * scale, .beta = 4, .crease_length = 0.2 * scale});
  for (std::size_t v = 0; v < result.positions.size(); ++v)
    EXPECT_LT((result.positions[v] - scale * (turn * plain.positions[v]) - Vector3(1, 2, 3)).norm(),
              1e-9 * scale);
}

TEST(FilterNormals, KeepsThemWhereTheyAreEqualAndUnit) {
  const Surface flat = make_surface(fixtures::flat_square(8, 0.2));
  for (const Vector3& n : filter_normals(flat, {.weight = 0.1, .beta = 0}).at_vertices)
    EXPECT_LT((n - Vector3(0, 0, 1)).norm(), 1e-14);
  const Surface torus = make_surface(fixtures::torus(20, 10));
  const FilteredNormals same = filter_normals(torus, {.weight = 1, .beta = 1});
  EXPECT_TRUE(same.at_vertices == vertex_normals(torus.mesh));
  EXPECT_TRUE(same.of_triangles == triangle_normals(torus.mesh));
  for (const double beta : {0.0, 5.0})
    for (const Vector3& n : filter_normals(torus, {.weight = 0.1, .beta = beta}).at_vertices)
      EXPECT_NEAR(n.norm(), 1, 1e-14);
}

TEST(FilterNormals, SmoothsAndSharpensThem) {
  // Around a cylinder normals turn evenly: they stay. Across the blunt edge of a wedge they turn
  // less after smoothing and more after sharpening.
  Mesh mesh = fixtures::flat_square(40);
  for (Vector3& p : mesh.positions) p.z() = -std::sqrt(0.01 + (p.x() - 0.5) * (p.x() - 0.5));
  const Surface wedge = make_surface(mesh);
  const auto turn = [&](double beta) {
    const auto normals = filter_normals(wedge, {.weight = 0.0025, .beta = beta}).at_vertices;
    const int row = 20 * 41;
    return std::acos(normals[row + 18].dot(normals[row + 22]));
  };
  EXPECT_LT(turn(0), 0.95 * turn(1));
  EXPECT_GT(turn(3), 1.1 * turn(1));
}

TEST(GeometryFilter, CopesWithUglyMeshes) {
  Mesh slivers = fixtures::flat_square(4);
  slivers.triangles.push_back({0, 1, 2});
  slivers.triangles.push_back({6, 6, 7});
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  for (const Mesh& mesh : {slivers, fixtures::nonmanifold_vertex(), fixtures::nonmanifold_edge(),
                           fixtures::moebius_strip(12), fixtures::one_triangle()}) {
    const Surface surface = make_surface(mesh);
    for (const double crease : {0.0, 0.5})
      for (const double beta : {0.0, 4.0}) {
        const GeometryFilterOptions options{.weight = 0.1, .beta = beta, .crease_length = crease};
        const Reshaped result = filter_positions(surface, options);
        for (const Vector3& p : result.positions) EXPECT_TRUE(p.allFinite());
        for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
          const int first = surface.vertex_from_source[surface.source_from_vertex[v]];
          EXPECT_EQ(result.positions[v], result.positions[first]);
        }
        for (const Vector3& n : filter_normals(surface, options).at_vertices)
          EXPECT_TRUE(n.allFinite());
      }
  }
}

TEST(GeometryFilter, RefusesWhatMeansNothing) {
  const Surface surface = make_surface(fixtures::flat_square(2));
  EXPECT_THAT(error_of([&] { filter_positions(surface, {.crease_length = -1}); }),
              HasSubstr("creases"));
  EXPECT_THAT(error_of([&] { filter_normals(surface, {.crease_alpha = NAN}); }),
              HasSubstr("smoothing"));
  EXPECT_THAT(error_of([&] { filter_positions(surface, {.weight = -1}); }), HasSubstr("weight"));
}

}  // namespace
}  // namespace mq
