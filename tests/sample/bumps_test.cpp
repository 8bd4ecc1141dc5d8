// Normal maps made for samples.
#include "mq/sample/bumps.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "mq/mesh/geometry.h"

namespace mq {
namespace {

struct Mapped {
  Surface surface;
  Atlas atlas;
  Image<float> map;
};

Mapped mapped(const std::string& name, int size) {
  const Sample sample = make_sample(name, {.texture_size = size, .triangles = 6000});
  Mapped made{make_surface(sample.mesh), {}, {}};
  made.atlas = make_atlas(made.surface, {sample.texture});
  made.map = paint_normals(made.surface, made.atlas);
  return made;
}

/// The map at a point of a half-edge, bilinearly, from the side of its triangle.
Vector3 normal_at(const Mapped& made, HalfEdge h, double along) {
  const TexelPoint& a = made.atlas.corners[h / 3][h % 3];
  const TexelPoint& b = made.atlas.corners[h / 3][(h % 3 + 1) % 3];
  const double x = std::lerp(a.column(), b.column(), along), y = std::lerp(a.row(), b.row(), along);
  const int i = int(std::floor(x)), j = int(std::floor(y));
  Vector3 normal;
  for (int k = 0; k < 3; ++k)
    normal[k] = 2 * std::lerp(std::lerp(made.map(i, j, k), made.map(i + 1, j, k), x - i),
                              std::lerp(made.map(i, j + 1, k), made.map(i + 1, j + 1, k), x - i), y - j) - 1;
  return normal;
}

/// Root mean square of how far the two sides of seams are from the bumps there.
double seam_error(const Mapped& made) {
  const std::vector<Vector3> normals = vertex_normals(made.surface.mesh);
  double sum = 0;
  int seams = 0;
  for (HalfEdge h = 0; h < HalfEdge(made.atlas.edges.size()); ++h) {
    if (made.atlas.edges[h] != EdgeKind::seam) continue;
    const Mesh& mesh = made.surface.mesh;
    const int t = h / 3, k = h % 3, l = (k + 1) % 3;
    const Vector3 place = (mesh.position(t, k) + mesh.position(t, l)) / 2;
    const Vector3 n = (normals[mesh.triangles[t][k]] + normals[mesh.triangles[t][l]]).normalized();
    sum += (normal_at(made, h, 0.5) - bumpy(n, place)).squaredNorm();
    ++seams;
  }
  EXPECT_GT(seams, 0);
  return std::sqrt(sum / seams);
}

TEST(Bumps, AreUnitVectorsEverywhere) {
  for (const char* name : {"cube", "bust_4"}) {
    const Mapped made = mapped(name, 256);
    for (int y = 0; y < 256; ++y)
      for (int x = 0; x < 256; ++x) {
        Vector3 n;
        for (int k = 0; k < 3; ++k) n[k] = 2 * double(made.map(x, y, k)) - 1;
        ASSERT_NEAR(n.norm(), 1, 1e-6) << name;
      }
  }
}

TEST(Bumps, AreTheSameOnBothSidesOfASeam) {
  // The error is that of bilinear interpolation, of the second order in the texel.
  for (const char* name : {"bust", "bust_4"}) {
    const double coarse = seam_error(mapped(name, 512)), fine = seam_error(mapped(name, 1024));
    EXPECT_LT(fine, 0.02) << name;
    EXPECT_LT(fine, 0.4 * coarse) << name;
  }
}

TEST(Bumps, LeaveTheNormalWhereTheyHaveNoHeight) {
  const Vector3 n = Vector3(1, 2, -2) / 3;
  EXPECT_NEAR((bumpy(n, {0.3, 0.1, 0.7}, {.height = 0}) - n).norm(), 0, 1e-15);
  EXPECT_GT((bumpy(n, {0.3, 0.1, 0.7}) - n).norm(), 0.01);
  EXPECT_NEAR(bumpy(n, {0.3, 0.1, 0.7}).norm(), 1, 1e-15);
}

TEST(Bumps, RepeatAfterTheirLength) {
  const Vector3 place(0.31, -0.2, 0.77);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR((bumpy(Vector3::UnitY(), place + 0.25 * Vector3::Unit(k), {.length = 0.25}) -
                 bumpy(Vector3::UnitY(), place, {.length = 0.25})).norm(), 0, 1e-12);
}

TEST(Bumps, AreEqualBitsForEqualOptionsAndAnyNumberOfThreads) {
  const auto bits = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return paint_normals(make_sample("bust", {.texture_size = 128, .triangles = 4000}));
  };
  const Image<float> one = bits(1);
  EXPECT_EQ(one, bits(2));
  EXPECT_EQ(one, bits(7));
}

}  // namespace
}  // namespace mq
