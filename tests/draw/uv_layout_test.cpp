#include "mq/draw/uv_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "draw/drawn_model.h"

namespace mq {
namespace {

using namespace fixtures;
using ::testing::HasSubstr;
using Lines = RenderOptions::Lines;

TEST(UvLayout, CoversTheShareOfTheTextureThatChartsDo) {
  const Model model(two_chart_quad(), noise(64, 64, 3));
  UvLayoutOptions options;
  options.side = 200;
  options.fill = UvLayoutOptions::Fill::charts;
  options.seams = Lines::hide;
  const Image<float> layout = draw_uv_layout(model.surface, model.atlas, nullptr, options);
  double first = 0, second = 0;
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      first += is_colour(layout, x, y, chart_colour(0), 1e-5f);
      second += is_colour(layout, x, y, chart_colour(1), 1e-5f);
    }
  EXPECT_NEAR(first / 40000, 0.08, 0.004);
  EXPECT_NEAR(second / 40000, 0.08, 0.004);
}

TEST(UvLayout, ShowsTexelsAsSquaresWhenNear) {
  const Model model(flat_square(1), noise(64, 64, 3));
  UvLayoutOptions options;
  options.side = 160, options.zoom = 8;
  options.center = {(20 + 0.0) / 64, (64 - 30.0) / 64};  // corner between texels 19|20 and 29|30
  options.fill = UvLayoutOptions::Fill::texture;
  const Image<float> layout = draw_uv_layout(model.surface, model.atlas, &model.texture, options);
  EXPECT_TRUE(is_colour(
      layout, 90, 90,
      {model.texture(20, 30, 0), model.texture(20, 30, 1), model.texture(20, 30, 2)}, 1e-5f));
  EXPECT_TRUE(is_colour(
      layout, 70, 70,
      {model.texture(19, 29, 0), model.texture(19, 29, 1), model.texture(19, 29, 2)}, 1e-5f));
  EXPECT_FALSE(
      is_colour(layout, 80, 90,
                {model.texture(20, 30, 0), model.texture(20, 30, 1), model.texture(20, 30, 2)},
                1e-5f));  // the grid
}

TEST(UvLayout, HatchesOverlapsAndNothingElse) {
  const auto red = [](const Mesh& mesh) {
    const Model model(mesh, Image<float>(32, 32, 3, 0.5f));
    UvLayoutOptions options;
    options.side = 100;
    options.seams = Lines::hide;
    const Image<float> layout = draw_uv_layout(model.surface, model.atlas, &model.texture, options);
    int count = 0;
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 100; ++x) count += layout(x, y, 0) > 0.7f && layout(x, y, 1) < 0.3f;
    return count;
  };
  EXPECT_EQ(red(flat_square(5)), 0);
  Mesh overlapping = two_chart_quad();
  for (int k = 0; k < 3; ++k) overlapping.uvs[3 + k] -= Vector2(0.5, 0.5);
  overlapping.uvs[5] = {0.3, 0.05};
  EXPECT_GT(red(overlapping), 50);
}

TEST(UvLayout, WorksFromOneTexelToManyAndForThousandsOfCharts) {
  Mesh mesh = flat_square(40);
  mesh = triangle_soup(mesh);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const Vector3& p = mesh.position(t, k);
      corners[k] = int(mesh.uvs.size());
      mesh.uvs.push_back(Vector2(0.5, 0.5) + 0.98 * Vector2(p.x() - 0.5, p.y() - 0.5) +
                         1e-4 * Vector2(t % 7, t % 5));
    }
    mesh.corner_uvs.push_back(corners);
  }
  const Surface surface = make_surface(mesh);
  UvLayoutOptions options;
  options.side = 256;
  for (const int size : {1, 37, 2048}) {
    const Image<float> texture(size, std::max(1, size / 2), 1, 0.5f);
    const Atlas atlas = make_atlas(surface, {{texture.width(), texture.height()}});
    EXPECT_EQ(atlas.charts.size(), 3200u);
    const Image<float> layout = draw_uv_layout(surface, atlas, &texture, options);
    EXPECT_EQ(std::max(layout.width(), layout.height()), 256);
  }
}

TEST(UvLayout, SaysWhatDoesNotFit) {
  const Model model(flat_square(1), noise(4, 4, 3));
  const auto error = [&](const UvLayoutOptions& options, const Image<float>* picture) {
    return error_of([&] { draw_uv_layout(model.surface, model.atlas, picture, options); });
  };
  UvLayoutOptions options;
  EXPECT_THAT(error(options, nullptr), HasSubstr("no pixels"));
  options.texture = 1;
  EXPECT_THAT(error(options, &model.texture), HasSubstr("no texture 1: the atlas has 1"));
  options.texture = 0, options.side = 0;
  EXPECT_THAT(error(options, &model.texture), HasSubstr("1 to 16384"));
}

}  // namespace
}  // namespace mq
