#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "draw/drawn_model.h"
#include "mq/draw/scene.h"
#include "mq/draw/sheets.h"
#include "mq/draw/uv_layout.h"

namespace mq {
namespace {

using namespace fixtures;
using ::testing::HasSubstr;
using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;
using Light = RenderOptions::Light;

/// The unit square of the xy-plane fills a square picture of `side` pixels exactly.
RenderOptions square_on(int side) {
  RenderOptions options;
  options.view = parse_view("front");
  options.view.projection = View::Projection::orthographic;
  options.view.target = Vector3(0.5, 0.5, 0);
  options.view.extent = 1;
  options.width = options.height = side;
  options.light = Light::none;
  return options;
}

constexpr Colour seam_colour = {1.f, 0.45f, 0.05f}, end_colour = {0.25f, 0.65f, 1.f};

// ---- Camera ----

TEST(Camera, HoldsTheModelTightly) {
  const Mesh mesh = torus(40, 20);
  for (const char* name : {"front", "right", "back", "left", "top", "bottom", "corner", "-70,-35"})
    for (const auto projection : {View::Projection::perspective, View::Projection::orthographic}) {
      View view = parse_view(name);
      view.projection = projection;
      const Camera camera(mesh, view, 300, 200);
      double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
      for (const Vector3& p : mesh.positions) {
        const auto q = camera.project(p);
        EXPECT_GT(q.depth, 0);
        left = std::min(left, q.x), right = std::max(right, q.x);
        top = std::min(top, q.y), bottom = std::max(bottom, q.y);
      }
      const double across = Camera::margin * 300, along = Camera::margin * 200;
      const double spare =
          std::min({left - across, 300 - across - right, top - along, 200 - along - bottom});
      EXPECT_NEAR(spare, 0, 1e-6) << name;
      EXPECT_TRUE(std::abs(left - (300 - right)) < 1e-6 || std::abs(top - (200 - bottom)) < 1e-6);
    }
}

TEST(Camera, ProjectsThePointsOfARayToItsPixel) {
  View view = parse_view("20,-50");
  for (const double extent : {0.0, 0.3}) {
    view.extent = extent;
    if (extent > 0) view.target = Vector3(0.2, 0.5, 0.7);
    for (const auto projection : {View::Projection::perspective, View::Projection::orthographic}) {
      view.projection = projection;
      const Camera camera(sphere(3), view, 320, 240);
      const Ray ray = camera.ray(17.25, 201.5);
      const auto place = camera.project(ray.origin + 3.7 * ray.direction);
      EXPECT_NEAR(place.x, 17.25, 1e-9);
      EXPECT_NEAR(place.y, 201.5, 1e-9);
    }
  }
}

TEST(Camera, PutsItsTargetInTheMiddleAtTheExtentAskedFor) {
  View view = parse_view("front");
  view.target = Vector3(0.3, 0.2, 0.9);
  view.extent = 0.1;
  const Camera camera(sphere(3), view, 400, 200);
  EXPECT_NEAR(camera.project(*view.target).x, 200, 1e-9);
  EXPECT_NEAR(camera.project(*view.target).y, 100, 1e-9);
  EXPECT_NEAR(camera.project(*view.target + Vector3(0, 0.05, 0)).y, 0, 1e-9);
}

TEST(Camera, KnowsTheSidesOfAModel) {
  const Mesh mesh = sphere(2);
  EXPECT_NEAR(Camera(mesh, parse_view("front"), 9, 9).backward().z(), 1, 1e-15);
  EXPECT_NEAR(Camera(mesh, parse_view("right"), 9, 9).backward().x(), 1, 1e-15);
  EXPECT_NEAR(Camera(mesh, parse_view("left"), 9, 9).backward().x(), -1, 1e-15);
  EXPECT_NEAR(Camera(mesh, parse_view("top"), 9, 9).backward().y(), 1, 1e-15);
  View upright_z = parse_view("front");
  upright_z.up = View::Up::z;
  EXPECT_NEAR(Camera(mesh, upright_z, 9, 9).backward().y(), -1, 1e-15);
  EXPECT_NEAR(Camera(mesh, upright_z, 9, 9).up().z(), 1, 1e-15);
}

TEST(Camera, StandsUprightOnAnyAxis) {
  const Mesh mesh = sphere(2);
  const Vector3 axes[] = {Vector3::UnitY(),  Vector3::UnitZ(),  Vector3::UnitX(),
                          -Vector3::UnitX(), -Vector3::UnitY(), -Vector3::UnitZ()};
  for (std::size_t k = 0; k < up_names().size(); ++k) {
    View view = parse_view("front");
    view.up = View::Up(k);
    const Camera camera(mesh, view, 9, 9);
    EXPECT_NEAR(camera.up().dot(axes[k]), 1, 1e-15) << up_names()[k];
    EXPECT_NEAR(camera.right().cross(camera.up()).dot(camera.backward()), 1, 1e-15) << up_names()[k];
    const Vector3 some(0.3, -0.2, 0.9);
    EXPECT_NEAR((to_upright(view.up, from_upright(view.up, some)) - some).norm(), 0, 1e-15) << up_names()[k];
  }
}

TEST(Camera, RefusesViewsItDoesNotKnow) {
  for (const char* text : {"side", "", "1,2,3", "30,95", "nan,0", "30", "1e9,0"})
    EXPECT_THAT(error_of([&] { parse_view(text); }), HasSubstr("view \"")) << text;
  EXPECT_THAT(error_of([] { Camera(Mesh(), {}, 9, 9); }), HasSubstr("no triangles"));
  Mesh bad = one_triangle();
  bad.positions[1].x() = NAN;
  EXPECT_THAT(error_of([&] { Camera(bad, {}, 9, 9); }), HasSubstr("vertex 1"));
}

// ---- Scene ----

TEST(Scene, FindsThePlaceInDoublePrecision) {
  Mesh mesh = flat_square(8, 0.2);
  for (Vector3& p : mesh.positions) p += Vector3(1000, -500, 10);
  const Surface surface = make_surface(mesh);
  const Scene scene(surface);
  const Random random(5);
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Vector3 point(1000 + random.uniform(2 * i, 0.01, 0.99),
                        -500 + random.uniform(2 * i + 1, 0.01, 0.99), 10);
    const Vector3 direction = Vector3(0.3, 0.1, -1).normalized();
    const Hit hit = scene.hit({point - 5 * direction, direction});
    ASSERT_GE(hit.triangle, 0);
    EXPECT_LT((hit.point - point).norm(), 1e-11);
  }
  EXPECT_EQ(scene.hit({{0, 0, 20}, {0, 0, -1}}).triangle, -1);
}

TEST(Scene, TakesTheLowerOfTwoTrianglesOnTheirEdge) {
  const Surface surface = make_surface(flat_square(1));
  const Scene scene(surface);
  for (double t = 0.125; t < 1; t += 0.125)
    EXPECT_EQ(scene.hit({{t, t, 1}, {0, 0, -1}}).triangle, 0);
}

// ---- Render ----

TEST(Render, ShowsASphereAsADiscOfTheRightSize) {
  const Surface surface = make_surface(sphere(5));
  const Renderer renderer(surface);
  for (const auto projection : {View::Projection::perspective, View::Projection::orthographic}) {
    RenderOptions options;
    options.paint = Paint::clay;
    options.view.projection = projection;
    options.width = 300, options.height = 200;
    options.backdrop.kind = Backdrop::Kind::transparent;
    const Image<float> picture = renderer.draw({}, options);
    double area = 0;
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 300; ++x) area += picture(x, y, 3);
    const double radius = 200 * (0.5 - Camera::margin);
    EXPECT_NEAR(area / (std::numbers::pi * radius * radius), 1, 3e-3);
  }
}

TEST(Render, ShowsEachTexelAtItsPlace) {
  const Model model(flat_square(3), noise(8, 8, 3));
  RenderOptions options = square_on(72);
  options.samples = 1;
  const Image<float> picture = Renderer(model.surface, &model.atlas).draw(model.paints(), options);
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(picture(9 * i + 4, 9 * j + 4, k), model.texture(i, j, k), 1e-6);
}

TEST(Render, RepeatsATextureThatChartsLeave) {
  Mesh mesh = flat_square(1);
  for (Vector2& uv : mesh.uvs) uv = 2 * uv;
  const Model model(mesh, noise(4, 4, 1));
  RenderOptions options = square_on(72);
  options.samples = 1;
  const Image<float> picture = Renderer(model.surface, &model.atlas).draw(model.paints(), options);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(picture(9 * i + 4, 4, 1), model.texture(i % 4, 0), 1e-6);
}

TEST(Render, GivesEachChartItsColour) {
  const Model model(two_chart_quad(), noise(16, 16, 3));
  RenderOptions options = square_on(40);
  options.paint = Paint::charts;
  const Image<float> picture = Renderer(model.surface, &model.atlas).draw({}, options);
  EXPECT_TRUE(is_colour(picture, 35, 35, chart_colour(model.atlas.chart[0]), 1e-6f));
  EXPECT_TRUE(is_colour(picture, 5, 5, chart_colour(model.atlas.chart[1]), 1e-6f));
  EXPECT_NE(chart_colour(0), chart_colour(1));
}

TEST(Render, DrawsSeamsAndEndsWithTheirWidth) {
  const Model model(two_chart_quad(), noise(16, 16, 3));
  RenderOptions options = square_on(200);
  options.view.extent = 1.25;
  options.paint = Paint::charts;
  options.seams = Lines::show;
  options.line_width = 4;
  const Image<float> picture = Renderer(model.surface, &model.atlas).draw({}, options);
  EXPECT_TRUE(is_colour(picture, 100, 99, seam_colour, 0.01f));
  EXPECT_TRUE(is_colour(picture, 60, 139, seam_colour, 0.01f));
  EXPECT_TRUE(is_colour(picture, 20, 100, end_colour, 0.01f));
  double blue = 0;
  for (int x = 0; x < 100; ++x) blue += is_colour(picture, x, 150, end_colour, 0.01f);
  EXPECT_NEAR(blue, 4, 1);
  EXPECT_TRUE(is_colour(picture, 140, 150, chart_colour(model.atlas.chart[0]), 1e-6f));
}

TEST(Render, HidesLinesBehindTheSurface) {
  Mesh small = flat_square(1);
  for (Vector3& p : small.positions) p = Vector3(0.25, 0.25, -1) + 0.5 * p;
  Mesh large = flat_square(1);
  large.corner_uvs.clear(), small.corner_uvs.clear();
  RenderOptions options = square_on(100);
  options.paint = Paint::clay;
  options.seams = Lines::show;
  const auto has_inner_line = [&](const Mesh& mesh) {
    const Surface surface = make_surface(mesh);
    const Image<float> picture = Renderer(surface).draw({}, options);
    bool found = false;
    for (int x = 10; x < 50; ++x) found = found || is_colour(picture, x, 50, end_colour, 0.1f);
    return found;
  };
  EXPECT_FALSE(has_inner_line(beside(large, small)));
  EXPECT_TRUE(has_inner_line(small));
}

TEST(Render, ColoursNumbersByTheirScale) {
  const Surface surface = make_surface(flat_square(4));
  std::vector<float> values;
  for (const Vector3& p : surface.mesh.positions) values.push_back(float(p.x()));
  RenderOptions options = square_on(50);
  options.paint = Paint::vertex_numbers;
  options.legend = RenderOptions::Legend::hide;
  options.samples = 1;
  const Image<float> picture = Renderer(surface).draw({.vertex_values = values}, options);
  for (int x = 0; x < 50; ++x)
    EXPECT_TRUE(is_colour(picture, x, 20, false_colour((x + 0.5) / 50, options.scale), 1e-4f)) << x;
}

TEST(Render, DrawsIsolinesAcrossTriangles) {
  const Surface surface = make_surface(flat_square(4));
  std::vector<float> values;
  for (const Vector3& p : surface.mesh.positions) values.push_back(float(p.x()));
  RenderOptions options = square_on(200);
  options.paint = Paint::vertex_numbers;
  options.legend = RenderOptions::Legend::hide;
  options.scale.isolines = 3;
  const Image<float> picture = Renderer(surface).draw({.vertex_values = values}, options);
  for (const int x : {50, 100, 150})
    EXPECT_LT(std::min(picture(x, 77, 0) + picture(x, 77, 1),
                       picture(x - 1, 77, 0) + picture(x - 1, 77, 1)),
              0.4);
  EXPECT_GT(picture(125, 77, 1), 0.5);
}

TEST(Render, KeepsStoredColoursWhereTheSurfaceFacesTheViewer) {
  const Model model(flat_square(1), Image<float>(4, 4, 3, 0.5f));
  RenderOptions options = square_on(20);
  options.light = Light::studio;
  const Renderer renderer(model.surface, &model.atlas);
  EXPECT_NEAR(renderer.draw(model.paints(), options)(10, 10, 1), 0.5, 0.01);
  options.view = parse_view("back");
  EXPECT_LT(renderer.draw(model.paints(), options)(10, 10, 1), 0.4);
}

TEST(Render, GivesEqualBitsForAnyNumberOfThreads) {
  Mesh mesh = torus(60, 30);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    mesh.uvs.emplace_back(double(v % 60) / 60, double(v / 60) / 30);
  mesh.corner_uvs = mesh.triangles;
  const Surface surface = make_surface(mesh);
  const Image<float> texture = noise(32, 32, 3);
  const Atlas atlas = make_atlas(surface, {{32, 32}}, {AtlasOptions::Flipped::keep});
  RenderOptions options;
  options.width = options.height = 150;
  options.seams = options.wires = Lines::show;
  std::vector<Image<float>> pictures;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    pictures.push_back(
        Renderer(surface, &atlas).draw({.textures = {&texture}, .vertex_values = {}}, options));
  }
  EXPECT_TRUE(pictures[0] == pictures[1]);
  EXPECT_TRUE(pictures[0] == pictures[2]);
}

TEST(Render, SaysWhatDoesNotFit) {
  const Model model(flat_square(1), noise(4, 4, 3));
  const Renderer renderer(model.surface, &model.atlas);
  const Renderer bare(model.surface);
  const Image<float> other = noise(5, 4, 3);
  const auto error = [&](const Renderer& r, const Paints& paints, const RenderOptions& options) {
    return error_of([&] { r.draw(paints, options); });
  };
  RenderOptions options;
  EXPECT_THAT(error(bare, model.paints(), options), HasSubstr("without texture coordinates"));
  EXPECT_THAT(error(renderer, {}, options), HasSubstr("0 pictures are given for an atlas of 1"));
  EXPECT_THAT(error(renderer, {.textures = {&other}, .vertex_values = {}}, options),
              HasSubstr("5 x 4 pixels, the atlas was made for 4 x 4"));
  options.paint = Paint::vertex_numbers;
  EXPECT_THAT(error(renderer, {}, options), HasSubstr("0 values are given for 4 vertices"));
  options.paint = Paint::texture_numbers, options.channel = 3;
  EXPECT_THAT(error(renderer, model.paints(), options), HasSubstr("no channel 3"));
  options.channel = 0, options.width = 60;
  EXPECT_THAT(error(renderer, model.paints(), options), HasSubstr("too narrow for a legend"));
  options.width = 0;
  EXPECT_THAT(error(renderer, model.paints(), options), HasSubstr("0 x 1024"));
  const Surface empty = make_surface(Mesh());
  options = {};
  options.paint = Paint::clay;
  EXPECT_THAT(error(Renderer(empty), {}, options), HasSubstr("no triangles"));
}

TEST(Render, DrawsDegenerateModelsWithoutHarm) {
  Mesh point = one_triangle();
  point.positions.assign(3, Vector3(5, 5, 5));
  Mesh far = one_triangle();
  for (Vector3& p : far.positions) p = 1e12 * (p + Vector3(1, 1, 1));
  RenderOptions options;
  options.paint = Paint::clay;
  options.width = options.height = 40;
  for (const Mesh& mesh : {point, far, nonmanifold_vertex(), moebius_strip(20)})
    for (const char* view : {"front", "right", "top", "corner"}) {
      options.view = parse_view(view);
      const Surface surface = make_surface(mesh);
      const Image<float> picture = Renderer(surface).draw({}, options);
      for (const float v : picture.values()) ASSERT_TRUE(std::isfinite(v));
    }
}

TEST(Render, LooksStraightAtAPlaceUnlessSomethingIsInFront) {
  const Surface surface = make_surface(torus(60, 30));
  const Renderer renderer(surface);
  const Sight outer = renderer.sight_of({1.4, 0, 0}, {1, 0, 0}, 0.1);
  EXPECT_TRUE(outer.clear);
  EXPECT_NEAR(outer.view.azimuth, 90, 1e-9);
  EXPECT_NEAR(outer.view.elevation, 0, 1e-9);
  const Sight inner =
      renderer.sight_of({0.6, 0, 0}, {-1, 0, 0}, 0.1);  // the other side is in front
  EXPECT_TRUE(inner.clear);
  EXPECT_GT(std::hypot(inner.view.azimuth + 90, inner.view.elevation), 1);
}

// ---- Several pictures at once ----

TEST(Renderer, DrawsSeveralPicturesAsItDrawsThemAlone) {
  const Model model(two_chart_quad(), noise(16, 16, 3));
  const Renderer renderer(model.surface, &model.atlas);
  RenderOptions options;
  options.width = 70, options.height = 60;
  std::vector<RenderOptions> wanted(5, options);
  wanted[1].seams = RenderOptions::Lines::show;
  wanted[2].paint = RenderOptions::Paint::charts, wanted[2].light = Light::none;
  wanted[3].paint = RenderOptions::Paint::clay;
  wanted[4].paint = RenderOptions::Paint::clay, wanted[4].wires = RenderOptions::Lines::show;
  const std::vector<Image<float>> together = renderer.draw_together(model.paints(), wanted);
  ASSERT_EQ(together.size(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k)
    EXPECT_TRUE(together[k] == renderer.draw(model.paints(), wanted[k])) << k;
  EXPECT_FALSE(together[3] == together[4]);
}

TEST(Renderer, DrawsOnlyPicturesOfOneViewTogether) {
  const Model model(two_chart_quad(), noise(16, 16, 3));
  const Renderer renderer(model.surface, &model.atlas);
  std::vector<RenderOptions> wanted(2);
  wanted[1].view = parse_view("back");
  EXPECT_THAT(error_of([&] { renderer.draw_together(model.paints(), wanted); }), HasSubstr("one view and size"));
  wanted[1] = wanted[0];
  wanted[1].paint = RenderOptions::Paint::texture_numbers;
  EXPECT_THAT(error_of([&] { renderer.draw_together(model.paints(), wanted); }), HasSubstr("one by one"));
  EXPECT_THAT(error_of([&] { renderer.draw_together(model.paints(), {}); }), HasSubstr("one at least"));
}

// ---- Sheets ----

TEST(InjectiveParts, ShowOneSurfaceFromManySidesAndBeforeAndAfter) {
  const Model model(flat_square(1), noise(4, 4, 3));
  const Renderer renderer(model.surface, &model.atlas);
  RenderOptions options;
  options.width = options.height = 50;
  SheetOptions sheet;
  sheet.gap = 0;
  const Image<float> pair =
      draw_versions(renderer, std::vector<Version>{{"before", model.paints()}, {"after", model.paints()}}, {}, options,
                    sheet);
  ASSERT_EQ(pair.width(), 100);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 50; ++x) ASSERT_EQ(pair(x, y, 0), pair(50 + x, y, 0));
  const Image<float> page =
      draw_views(renderer, model.paints(), {"front", "back", "10,20"}, options, sheet);
  EXPECT_GE(page.width() * page.height(), 3 * 50 * 50);
  EXPECT_THAT(error_of([&] { draw_views(renderer, model.paints(), {}, options); }),
              HasSubstr("no view"));
}

}  // namespace
}  // namespace mq
