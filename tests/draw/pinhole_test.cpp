// Cameras of photographs and their lenses.
#include "mq/draw/camera_lines.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/draw/pinhole.h"
#include "mq/draw/render.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

TEST(PinholeCamera, IsTheRenderersCamera) {
  const Mesh mesh = fixtures::sphere(2);
  View view = parse_view("40,-25");
  const Camera camera(mesh, view, 300, 200);
  const PinholeCamera pinhole = pinhole_of(camera);
  for (const Vector3& p : mesh.positions) {
    const Camera::Projected expected = camera.project(p);
    const auto place = pinhole.project(p);
    ASSERT_TRUE(place);
    EXPECT_NEAR(place->x(), expected.x, 1e-9);
    EXPECT_NEAR(place->y(), expected.y, 1e-9);
  }
  EXPECT_FALSE(pinhole.project(pinhole.center() + camera.backward()));
  EXPECT_FALSE(pinhole.project(pinhole.center() - camera.backward() + 10 * camera.right()));
  view.projection = View::Projection::orthographic;
  EXPECT_FALSE(fixtures::error_of([&] { pinhole_of(Camera(mesh, view, 300, 200)); }).empty());
}

TEST(PinholeCamera, IsLookedThroughByTheRenderer) {
  const Mesh mesh = fixtures::sphere(2);
  PinholeCamera pinhole{.width = 300, .height = 200, .fx = 260, .fy = 260, .cx = 140, .cy = 110};
  pinhole.rotation = Eigen::AngleAxisd(0.4, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  pinhole.translation = {0.1, -0.2, 4};
  View view;
  view.through = standing(pinhole);
  // Half as large, and 20 pixels more on either side.
  const Camera camera(mesh, view, 190, 100);
  for (const Vector3& p : mesh.positions) {
    const auto place = pinhole.project(p);
    ASSERT_TRUE(place);
    EXPECT_NEAR(camera.project(p).x, place->x() / 2 + 20, 1e-9);
    EXPECT_NEAR(camera.project(p).y, place->y() / 2, 1e-9);
  }
  // Lines that pass the viewer are drawn as far as they lie in front.
  pinhole.translation = {0, 0, 0.2};
  view.through = standing(pinhole);
  const Surface surface = make_surface(mesh);
  RenderOptions options{.view = view, .width = 60, .height = 40, .paint = RenderOptions::Paint::clay};
  const Image<float> bare = Renderer(surface).draw({}, options);
  options.wires = RenderOptions::Lines::show;
  const Image<float> wires = Renderer(surface).draw({}, options);
  EXPECT_FALSE(bare == wires);
}

/// By hand: (a, b) = (0.5, 0.25), r² = 0.3125.
TEST(PinholeCamera, DistortsAsOpenCvDoes) {
  PinholeCamera camera{.width = 100, .height = 100, .fx = 40, .fy = 50, .cx = 45, .cy = 55};
  camera.lens = {.k1 = 0.1, .k2 = -0.2, .k3 = 0.05, .p1 = 0.01, .p2 = -0.02};
  const double r2 = 0.3125, radial = 1 + 0.1 * r2 - 0.2 * r2 * r2 + 0.05 * r2 * r2 * r2;
  const auto place = camera.project({1, 0.5, 2});
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 40 * (0.5 * radial + 0.02 * 0.125 - 0.02 * (r2 + 0.5)) + 45, 1e-12);
  EXPECT_NEAR(place->y(), 50 * (0.25 * radial + 0.01 * (r2 + 0.125) - 0.04 * 0.125) + 55, 1e-12);

  // A barrel so strong that it turns back: r (1 − r²) is largest at r = 1/√3.
  PinholeCamera barrel{.width = 100, .height = 100, .fx = 50, .fy = 50, .cx = 50, .cy = 50};
  barrel.lens.k1 = -1;
  EXPECT_TRUE(barrel.project({0.57, 0, 1}));
  EXPECT_FALSE(barrel.project({0.58, 0, 1}));
  EXPECT_FALSE(barrel.project({0.95, 0, 1}));
}

TEST(PinholeCamera, FollowsThePicturesSize) {
  const PinholeCamera camera{
      .width = 400, .height = 300, .fx = 350, .fy = 360, .cx = 190, .cy = 140};
  const PinholeCamera half = scaled(camera, 200, 150);
  const Vector3 point(0.2, -0.1, 1);
  EXPECT_NEAR((*half.project(point) - 0.5 * *camera.project(point)).norm(), 0, 1e-12);
  EXPECT_FALSE(fixtures::error_of([&] { scaled(camera, 200, 200); }).empty());
}

constexpr double degrees = std::numbers::pi / 180;

/// A direction at the angle from the axis, towards (3, 4) of the picture.
Vector3 slanted(double angle) {
  return {0.6 * std::sin(angle), 0.8 * std::sin(angle), std::cos(angle)};
}

/// By hand: each projection's radius at 40 degrees.
TEST(Lens, BendsAsItsProjectionSays) {
  using Projection = Lens::Projection;
  const double angle = 40 * degrees, tangent = std::tan(angle);
  const auto radius = [&](Projection projection, double shape) {
    const auto place = Lens{.projection = projection, .shape = shape}.image(7 * slanted(angle));
    EXPECT_NEAR(place->y() / place->x(), 4.0 / 3, 1e-14);
    return place->norm();
  };
  EXPECT_NEAR(radius(Projection::perspective, 0), tangent, 1e-14);
  EXPECT_NEAR(radius(Projection::fisheye, 0), angle, 1e-14);
  EXPECT_NEAR(radius(Projection::equisolid, 0), 2 * std::sin(angle / 2), 1e-14);
  EXPECT_NEAR(radius(Projection::field_of_view, 0.9), std::atan(2 * std::tan(0.45) * tangent) / 0.9,
              1e-14);
  EXPECT_NEAR(radius(Projection::field_of_view, 1e-7), tangent, 1e-12);
  const double u = radius(Projection::division, -0.3);
  EXPECT_NEAR(u / (1 - 0.3 * u * u), tangent, 1e-14);
}

/// By hand, on what a fisheye makes of the direction.
TEST(Lens, DistortsWhatItsProjectionGives) {
  const Lens lens{.projection = Lens::Projection::fisheye,
                  .k1 = 0.05,
                  .k2 = -0.01,
                  .k3 = 0.003,
                  .k4 = -0.0005,
                  .d1 = 0.02,
                  .d2 = 0.001,
                  .d3 = 0.0003,
                  .p1 = 0.001,
                  .p2 = -0.002,
                  .p3 = 0.1,
                  .p4 = 0.05,
                  .s1 = 0.0004,
                  .s2 = -0.0006};
  const double r = 0.8, a = 0.48, b = 0.64, q = r * r;
  const double radial = (1 + 0.05 * q - 0.01 * q * q + 0.003 * q * q * q - 0.0005 * q * q * q * q) /
                        (1 + 0.02 * q + 0.001 * q * q + 0.0003 * q * q * q);
  const double outwards = 1 + 0.1 * q + 0.05 * q * q;
  const auto place = lens.image(slanted(r));
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(),
              a * radial + (0.002 * a * b - 0.002 * (q + 2 * a * a)) * outwards + 0.0004 * q, 1e-14);
  EXPECT_NEAR(place->y(),
              b * radial + (0.001 * (q + 2 * b * b) - 0.004 * a * b) * outwards - 0.0006 * q, 1e-14);
  EXPECT_EQ(lens_text(lens), "fisheye, k1 k2 k3 k4 d1 d2 d3 p1 p2 p3 p4 s1 s2");
  EXPECT_EQ(lens_text({}), "perspective");
}

TEST(Lens, ShowsNothingTwice) {
  // A barrel that turns back at r² = 0.333 and, as a polynomial, turns again further out.
  const Lens barrel{.k1 = -1, .k2 = 0.25};
  EXPECT_TRUE(barrel.image({0.6, 0, 1}));
  EXPECT_GT(1 + 3 * barrel.k1 * 9 + 5 * barrel.k2 * 81, 0);
  EXPECT_FALSE(barrel.image({3, 0, 1}));
  // A quotient: r / (1 + r²) is largest at 1.
  const Lens quotient{.d1 = 1};
  EXPECT_TRUE(quotient.image({0.99, 0, 1}));
  EXPECT_FALSE(quotient.image({1.01, 0, 1}));
  // And one with a pole.
  EXPECT_FALSE(Lens{.d1 = -1}.image({1.5, 0, 1}));
  // θ (1 − 0.1 θ²) is largest at √(10/3), 104.6 degrees.
  const Lens fisheye{.projection = Lens::Projection::fisheye, .k1 = -0.1};
  EXPECT_TRUE(fisheye.image(slanted(104 * degrees)));
  EXPECT_FALSE(fisheye.image(slanted(105 * degrees)));
}

TEST(Lens, SeesBehindItselfOnlyWhereItIsAFisheye) {
  using Projection = Lens::Projection;
  const Vector3 behind = slanted(95 * degrees);
  const auto sees = [&](Projection projection, double shape) {
    return Lens{.projection = projection, .shape = shape}.image(behind).has_value();
  };
  EXPECT_FALSE(sees(Projection::perspective, 0));
  EXPECT_FALSE(sees(Projection::field_of_view, 0.9));
  EXPECT_FALSE(sees(Projection::division, 0.1));
  EXPECT_TRUE(sees(Projection::division, -0.1));
  EXPECT_TRUE(sees(Projection::fisheye, 0));
  EXPECT_TRUE(sees(Projection::equisolid, 0));
  for (const Projection projection : {Projection::perspective, Projection::fisheye,
                                      Projection::equisolid, Projection::division})
    EXPECT_FALSE(Lens{.projection = projection}.image({0, 0, -1}));
}

TEST(PinholeCamera, LooksInTheDirectionOfAPlace) {
  using Projection = Lens::Projection;
  PinholeCamera camera{.width = 400, .height = 300, .fx = 350, .fy = 360, .cx = 190, .cy = 140, .skew = 4};
  camera.rotation = Eigen::AngleAxisd(0.8, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  camera.translation = Vector3(0.3, -2, 5);
  for (const auto& [projection, shape] : {std::pair{Projection::perspective, 0.0}, {Projection::fisheye, 0.0},
                                          {Projection::equisolid, 0.0}, {Projection::field_of_view, 0.9},
                                          {Projection::division, -0.3}}) {
    camera.lens = {.projection = projection, .shape = shape};
    for (const Vector2& place : {Vector2(0.5, 0.5), Vector2(190, 140), Vector2(399, 20), Vector2(250, 299)}) {
      const Vector3 direction = undistorted_direction(camera, place.x(), place.y());
      EXPECT_NEAR(direction.norm(), 1, 1e-12);
      const auto shown = camera.project(camera.center() + 3 * direction);
      ASSERT_TRUE(shown) << projection_name(projection);
      EXPECT_NEAR((*shown - place).norm(), 0, 1e-9) << projection_name(projection);
    }
  }
}

TEST(PinholeCamera, LeansAsItsSkewSays) {
  PinholeCamera camera{.width = 400, .height = 300, .fx = 350, .fy = 360, .cx = 190, .cy = 140};
  const Vector3 point(0.2, -0.1, 1);
  const Vector2 upright = *camera.project(point);
  camera.skew = 3;
  EXPECT_NEAR((*camera.project(point) - upright - Vector2(-0.3, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((*scaled(camera, 200, 150).project(point) - 0.5 * *camera.project(point)).norm(), 0,
              1e-12);
}

/// A square before one camera, of which the picture shows the left half; a second looks away.
TEST(CameraLines, CountWhatLiesInViews) {
  const Mesh mesh = fixtures::flat_square(10);  // [0, 1]², z = 0
  PinholeCamera left{.width = 100, .height = 200, .fx = 200, .fy = 200, .cx = 100, .cy = 100};
  left.translation = Vector3(-0.5, -0.5, 1);
  PinholeCamera away = left;
  away.translation.z() = -1;
  const std::vector<int> views = views_of_triangles(mesh, std::vector{left, away, left});
  ASSERT_EQ(int(views.size()), mesh.triangle_count());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const double x = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)).x() / 3;
    EXPECT_EQ(views[std::size_t(t)], x < 0.5 ? 2 : 0) << x;
  }
}

TEST(CameraLines, AreInThePictureAndHiddenByTheModel) {
  const Mesh sphere = fixtures::sphere(3);
  const Surface surface = make_surface(sphere);
  const Renderer renderer(surface);
  RenderOptions options;
  options.width = options.height = 200;
  options.paint = RenderOptions::Paint::clay;
  options.view = parse_view("front");
  const Colour red = {1, 0, 0};
  const auto reds = [&](const Vector3& from, const Vector3& to) {
    options.lines = {{from, to, red}};
    const Image<float> picture = renderer.draw({}, options);
    int count = 0;
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x) count += picture(x, y, 0) > 0.7F && picture(x, y, 1) < 0.4F;
    return count;
  };
  EXPECT_EQ(reds({-0.3, 0, -1.5}, {0.3, 0, -1.5}), 0);  // behind
  EXPECT_GT(reds({-0.3, 0, 1.5}, {0.3, 0, 1.5}), 20);   // in front
  EXPECT_GT(reds({3, 0, 0}, {4, 0, 0}), 20);            // far aside, and yet in view
  const PinholeCamera camera = pinhole_of(Camera(sphere, options.view, 300, 200));
  for (const SpaceLine& line : lines_of_cameras(std::vector{camera}, 0.5))
    EXPECT_LE((line.to - camera.center()).norm(), 0.76);
}

}  // namespace
}  // namespace mq
