// Which triangles cover which texels.
#include "mq/atlas/coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "atlas/atlas_fixtures.h"
#include "mq/atlas/overlap_depth.h"

namespace mq {
namespace {

int sum(const Image<int>& counts) {
  return std::accumulate(counts.values().begin(), counts.values().end(), 0);
}

TEST(Coverage, CountsEveryCentreOnce) {
  for (const int size : {16, 17, 64}) {
    const auto model = fixtures::textured(fixtures::flat_square(7, 0.2), {{size, size}});
    const Coverage coverage = texel_coverage(model->surface, model->atlas).front();
    for (const int count : coverage.count.values()) EXPECT_EQ(count, 1);
    for (const int triangle : coverage.triangle.values()) EXPECT_GE(triangle, 0);
  }
}

/// Corners on centres, edges through centres: from 4 to 12 of 16, half of the border belongs.
TEST(Coverage, CountsCentresOnEdgesOnce) {
  const auto model = fixtures::textured(fixtures::uv_on_texel_line(16), {{16, 16}});
  const Coverage coverage = texel_coverage(model->surface, model->atlas).front();
  EXPECT_EQ(*std::ranges::max_element(coverage.count.values()), 1);
  EXPECT_EQ(sum(coverage.count), 64);
}

TEST(Coverage, CountsOverlapsAndMirroredCharts) {
  Mesh mesh = fixtures::split_two_chart_quad();
  mesh.corner_uvs[1] = {0, 2, 1};  // over the first, turned over
  const auto model = fixtures::textured(mesh, {{40, 40}}, {.flipped = AtlasOptions::Flipped::keep});
  const Coverage coverage = texel_coverage(model->surface, model->atlas).front();
  EXPECT_EQ(*std::ranges::max_element(coverage.count.values()), 2);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x)
      if (coverage.count(x, y) == 2) {
        EXPECT_EQ(coverage.triangle(x, y), 0);
      }
}

TEST(Coverage, WrapsWhereTheTextureRepeats) {
  Mesh mesh = fixtures::one_triangle();
  for (Vector2& uv : mesh.uvs) uv = 0.5 * uv + Vector2(0.75, 0.75);
  const auto repeat = fixtures::textured(mesh, {{32, 32, Wrap::repeat}});
  const auto clamp = fixtures::textured(mesh, {{32, 32, Wrap::clamp}});
  EXPECT_NEAR(sum(texel_coverage(repeat->surface, repeat->atlas).front().count), 128, 10);
  EXPECT_LT(sum(texel_coverage(clamp->surface, clamp->atlas).front().count), 100);
  EXPECT_GT(sum(texel_coverage(clamp->surface, clamp->atlas).front().count), 20);
}

/// All triangles of a mesh on the same half of the texture.
std::unique_ptr<fixtures::Textured> heap_of(int cells, int size) {
  Mesh mesh = fixtures::flat_square(cells, 0.2);
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.corner_uvs.assign(mesh.triangles.size(), {0, 1, 2});
  return fixtures::textured(mesh, {{size, size}}, {.flipped = AtlasOptions::Flipped::keep});
}

TEST(OverlapDepth, IsHowManyTrianglesLieOnATexel) {
  const auto flat = fixtures::textured(fixtures::flat_square(7, 0.2), {{64, 64}});
  EXPECT_EQ(overlap_depth(flat->surface, flat->atlas).mean, 1);
  EXPECT_EQ(overlap_depth(flat->surface, flat->atlas).share, 0);
  for (const int size : {64, 2048}) {  // of the latter in a smaller one
    const auto heap = heap_of(7, size);
    const OverlapDepth depth = overlap_depth(heap->surface, heap->atlas);
    EXPECT_EQ(depth.mean, double(heap->surface.triangle_count()));
    EXPECT_EQ(depth.share, 1);
  }
}

TEST(OverlapDepth, IsRefusedWhereItWouldTakeGigabytes) {
  const auto cheap = heap_of(40, 64), dear = heap_of(40, 1024);  // 3200 triangles
  EXPECT_TRUE(deep_overlaps(cheap->surface, cheap->atlas).empty());
  const Defects found = deep_overlaps(dear->surface, dear->atlas);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(refused(found));
  EXPECT_THAT(found[0].message, testing::HasSubstr("that lie 3200 deep on each other"));
}

}  // namespace
}  // namespace mq
