// How far textures jump at seams, and where that is looked at.
#include "mq/draw/seam_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "draw/drawn_model.h"
#include "mq/draw/sheets.h"

namespace mq {
namespace {

using namespace fixtures;
using ::testing::HasSubstr;

TEST(SeamDifference, VanishesForOneColour) {
  const Model model(two_chart_quad(), Image<float>(32, 32, 3, 0.25f));
  const SeamDifference d = seam_difference(model.surface, model.atlas, {&model.texture});
  EXPECT_EQ(d.rms, 0);
  EXPECT_NEAR(d.length, std::sqrt(2), 1e-12);
  EXPECT_GT(d.places, 30);
}

TEST(SeamDifference, MeasuresTheJumpBetweenTwoCharts) {
  Image<float> halves(32, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 16; x < 32; ++x) halves(x, y, 0) = 1;
  const Model model(two_chart_quad(), halves);
  const SeamDifference d = seam_difference(model.surface, model.atlas, {&model.texture});
  EXPECT_NEAR(d.rms, 1 / std::sqrt(3), 1e-6);
  EXPECT_NEAR(d.worst.difference, 1 / std::sqrt(3), 1e-6);
  EXPECT_EQ(d.worst.here[0] + d.worst.there[0], 1);
  EXPECT_NEAR(d.worst.point.x(), d.worst.point.y(), 1e-12);
  EXPECT_NEAR(d.worst.normal.z(), 1, 1e-12);
}

TEST(SeamDifference, FindsTheSpotThatDiffers) {
  Image<float> spot(64, 64, 1);
  const Model plain(two_chart_quad(), spot);
  // The texel nearest to the middle of the diagonal, in the first chart.
  spot(16, 48) = spot(15, 48) = spot(15, 47) = spot(16, 47) = 1;
  const SeamDifference d = seam_difference(plain.surface, plain.atlas, {&spot});
  EXPECT_NEAR(d.worst.point.x(), 0.5, 0.1);
  EXPECT_GT(d.worst.difference, 0.9);
  EXPECT_LT(d.rms, 0.5);
}

TEST(SeamDifference, IsLookedAtWhereItShows) {
  Image<float> halves(32, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 16; x < 32; ++x) halves(x, y, 0) = 1;
  const Model model(two_chart_quad(), halves);
  const SeamDifference d = seam_difference(model.surface, model.atlas, {&model.texture});
  ASSERT_EQ(d.edges.size(), 1u);
  EXPECT_NEAR(d.edges[0].weight, std::sqrt(2) / 3, 1e-6);
  const Renderer renderer(model.surface, &model.atlas);
  const Sight sight = sight_of_worst_seam(renderer, model.atlas, d, 4);
  EXPECT_TRUE(sight.clear);
  RenderOptions options;
  options.width = options.height = 64;
  options.view = sight.view;
  options.light = RenderOptions::Light::none;
  const Image<float> picture = renderer.draw(model.paints(), options);
  const auto [least, most] = std::ranges::minmax(
      {picture(8, 8, 0), picture(8, 56, 0), picture(56, 8, 0), picture(56, 56, 0)});
  EXPECT_EQ(least, 0);
  EXPECT_EQ(most, 1);
}

/// Two squares, of 0.4 and 0.6, and beside them a strip of a texel's width, which is black.
Model squares_and_a_sliver() {
  Mesh mesh;
  const double x[] = {0, 1, 2, 2.02, 3};
  for (const double at : x)
    for (const double y : {0.0, 1.0}) mesh.positions.push_back({at, y, 0});
  const double left[] = {0.05, 0.35, 0.65, 0.68}, right[] = {0.3, 0.6, 0.66, 0.93};
  for (int k = 0; k < 4; ++k) {
    const int v = 2 * k, t = 4 * k;
    for (const Vector2& uv : {Vector2(left[k], 0.1), Vector2(right[k], 0.1), Vector2(right[k], 0.4), Vector2(left[k], 0.4)})
      mesh.uvs.push_back(uv);
    mesh.triangles.push_back({v, v + 2, v + 3}), mesh.corner_uvs.push_back({t, t + 1, t + 2});
    mesh.triangles.push_back({v, v + 3, v + 1}), mesh.corner_uvs.push_back({t, t + 2, t + 3});
  }
  Image<float> picture(100, 100, 1, 0.6F);
  for (int y = 0; y < 100; ++y) {
    for (int i = 0; i < 32; ++i) picture(i, y) = 0.4F;
    for (int i = 63; i < 68; ++i) picture(i, y) = 0;
  }
  return {mesh, picture};
}

TEST(SeamDifference, IsLookedAtWhereChartsAreLargeEnoughToSee) {
  const Model model = squares_and_a_sliver();
  const SeamDifference d = seam_difference(model.surface, model.atlas, {&model.texture});
  EXPECT_GT(d.worst.point.x(), 1.9);
  const Renderer renderer(model.surface, &model.atlas);
  const Sight sight = sight_of_worst_seam(renderer, model.atlas, d, 20);
  EXPECT_TRUE(sight.clear);
  EXPECT_NEAR(sight.view.target->x(), 1, 1e-9);
}

TEST(SeamDifference, SaysThatThereIsNoSeam) {
  const Model model(flat_square(2), noise(8, 8, 3));
  const SeamDifference d = seam_difference(model.surface, model.atlas, {&model.texture});
  EXPECT_EQ(d.worst.edge, -1);
  EXPECT_EQ(d.length, 0);
  const Renderer renderer(model.surface, &model.atlas);
  EXPECT_THAT(error_of([&] { sight_of_worst_seam(renderer, model.atlas, d, 40); }),
              HasSubstr("no seam"));
}

}  // namespace
}  // namespace mq
