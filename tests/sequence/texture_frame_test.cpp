#include "mq/sequence/texture_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The square [0, 1]², cut into n × n squares of two triangles, moved to `height`; its texture
/// coordinates are (x, y) shrunk to `share` of the texture's side.
Mesh square(int n, double height = 0, double share = 1) {
  Mesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      mesh.positions.emplace_back(double(x) / n, double(y) / n, height);
      mesh.uvs.emplace_back(share * x / n, share * y / n);
    }
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int v = y * (n + 1) + x;
      mesh.triangles.push_back({v, v + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

/// Red is x, green y, blue x·y, of the captured point.
ColourAt by_place(const Mesh& mesh) {
  return [&mesh](const ClosestPoint& point) {
    Vector3 p = Vector3::Zero();
    for (int k = 0; k < 3; ++k) p += point.barycentric[k] * mesh.position(point.triangle, k);
    return std::array{float(p.x()), float(p.y()), float(p.x() * p.y())};
  };
}

TEST(TextureFrame, ShowsWhatWasCapturedWhateverItsTriangles) {
  const Mesh surface = square(3), captured = square(7);
  const TextureFrame frame = resample_texture(surface, captured, by_place(captured),
                                              {.width = 32, .height = 16, .samples = 3});
  EXPECT_EQ(frame.texels, 32 * 16);
  EXPECT_EQ(frame.unseen, 0);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      const double u = (x + 0.5) / 32, v = 1 - (y + 0.5) / 16;
      EXPECT_NEAR(frame.picture(x, y, 0), u, 1e-6);
      EXPECT_NEAR(frame.picture(x, y, 1), v, 1e-6);
      EXPECT_NEAR(frame.picture(x, y, 2), u * v, 1e-6);  // symmetric samples of a bilinear function
    }
}

TEST(TextureFrame, GoesOnOutsideOfChartsWithTheNearestTexel) {
  const Mesh surface = square(4, 0, 0.5), captured = square(5);
  const TextureFrame frame =
      resample_texture(surface, captured, by_place(captured), {.width = 32, .height = 32});
  EXPECT_EQ(frame.texels, 16 * 16);
  // Beyond the rim colours are those of the rim: its samples, clamped to the surface.
  for (int y = 18; y < 32; ++y)
    for (int x = 18; x < 32; ++x) {
      EXPECT_NEAR(frame.picture(x, y, 0), 1, 0.05);
      EXPECT_NEAR(frame.picture(x, y, 1), frame.picture(16, y, 1), 1e-6);
    }
}

TEST(TextureFrame, LeavesOutWhatIsFarOrFacesAway) {
  const Mesh surface = square(4), far = square(4, 0.5);
  EXPECT_EQ(resample_texture(surface, far, by_place(far), {.width = 16, .height = 16}).unseen, 256);
  Mesh away = square(4);
  for (Triangle& t : away.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(resample_texture(surface, away, by_place(away), {.width = 16, .height = 16}).unseen,
            256);
  // Half of it is there: the rest has the colours of where that ends.
  Mesh half = square(4);
  std::erase_if(half.triangles, [&](const Triangle& t) {
    return half.positions[t[0]].x() + half.positions[t[1]].x() + half.positions[t[2]].x() > 1.5;
  });
  const TextureFrame frame =
      resample_texture(surface, half, by_place(half), {.width = 64, .height = 64});
  EXPECT_NEAR(double(frame.unseen) / double(frame.texels), 0.5, 0.05);
  EXPECT_NEAR(frame.picture(60, 30, 0), 0.5, 0.05);
}

TEST(TextureFrame, SaysWhatItNeeds) {
  Mesh bare = square(2);
  bare.corner_uvs.clear();
  const Mesh captured = square(2);
  EXPECT_THROW(resample_texture(bare, captured, by_place(captured)), InvalidInput);
  EXPECT_THROW(resample_texture(captured, Mesh(), by_place(captured)), InvalidInput);
  EXPECT_THROW(resample_texture(captured, captured, by_place(captured), {.samples = 0}),
               InvalidInput);
}

}  // namespace
}  // namespace mq
