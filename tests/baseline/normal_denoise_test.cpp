// Baselines for noisy normals: what stays, and that noise goes and creases stay.

#include "mq/baseline/normal_denoise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "fixtures.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

using fixtures::error_of;
using testing::HasSubstr;

/// A cube of 6·2·24² triangles with noise of `share` of an edge.
Surface noisy_cube(double share) {
  Mesh mesh = cube_cross(24).mesh;
  const Random random(8);
  const Surface clean = make_surface(mesh);
  const double most = share * mean_edge_length(clean);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      mesh.positions[v][k] +=
          most *
          random.uniform(3 * std::uint64_t(clean.vertex_from_source[v]) + std::uint64_t(k), -1, 1);
  return make_surface(mesh);
}

/// Mean angle to the normals of the cube, radians.
double error(const std::vector<Vector3>& normals) {
  const auto clean = triangle_normals(cube_cross(24).mesh);
  double sum = 0;
  for (std::size_t t = 0; t < normals.size(); ++t)
    sum += std::acos(std::clamp(clean[t].dot(normals[t]), -1.0, 1.0));
  return sum / double(normals.size());
}

TEST(NormalDenoise, KeepsAPlaneAndACube) {
  for (const Surface& surface :
       {make_surface(fixtures::flat_square(10, 0.2)), make_surface(cube_cross(8).mesh)}) {
    const auto normals = triangle_normals(surface.mesh);
    const auto bilateral = bilateral_normals(surface), shifted = mean_shift_normals(surface);
    for (std::size_t t = 0; t < normals.size(); ++t) {
      // Across an edge of the cube, |n − n'| = √2 = 4 σ counts exp(−8).
      EXPECT_LT((bilateral[t] - normals[t]).norm(), 0.01);
      EXPECT_LT((shifted[t] - normals[t]).norm(), 0.01);
    }
  }
}

TEST(NormalDenoise, TakesNoiseOffACube) {
  const Surface surface = noisy_cube(0.1);
  const double before = error(triangle_normals(surface.mesh));
  EXPECT_GT(before, 0.1);
  EXPECT_LT(error(bilateral_normals(surface)), 0.2 * before);
  EXPECT_LT(error(mean_shift_normals(surface)), 0.5 * before);
}

TEST(NormalDenoise, LeavesTheInputWhereNothingIsAsked) {
  const Surface surface = noisy_cube(0.1);
  EXPECT_TRUE(bilateral_normals(surface, {.iterations = 0}) == triangle_normals(surface.mesh));
  EXPECT_TRUE(mean_shift_normals(surface, {.most_steps = 0}) == triangle_normals(surface.mesh));
}

TEST(NormalDenoise, IsTheSameForAnyNumberOfThreads) {
  const Surface surface = noisy_cube(0.2);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    auto both = bilateral_normals(surface);
    const auto shifted = mean_shift_normals(surface);
    both.insert(both.end(), shifted.begin(), shifted.end());
    return both;
  };
  const auto one = with(1);
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(7));
}

TEST(NormalDenoise, CopesWithUglyMeshes) {
  Mesh slivers = fixtures::flat_square(4);
  slivers.triangles.push_back({0, 1, 2});
  slivers.triangles.push_back({6, 6, 7});
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  for (const Mesh& mesh : {slivers, fixtures::nonmanifold_vertex(), fixtures::nonmanifold_edge(),
                           fixtures::moebius_strip(12), fixtures::one_triangle()}) {
    const Surface surface = make_surface(mesh);
    for (const auto& normals : {bilateral_normals(surface), mean_shift_normals(surface)})
      for (std::size_t t = 0; t < normals.size(); ++t)
        EXPECT_NEAR(normals[t].norm(), surface.degenerate[t] ? 0 : 1, 1e-12);
  }
}

TEST(NormalDenoise, RefusesOptionsOutOfRange) {
  const Surface surface = make_surface(fixtures::flat_square(2));
  EXPECT_THAT(error_of([&] { bilateral_normals(surface, {.place = 0}); }), HasSubstr("reach"));
  EXPECT_THAT(error_of([&] { bilateral_normals(surface, {.iterations = -1}); }),
              HasSubstr("iterations"));
  EXPECT_THAT(error_of([&] { mean_shift_normals(surface, {.difference = NAN}); }),
              HasSubstr("bandwidth"));
}

}  // namespace
}  // namespace mq
