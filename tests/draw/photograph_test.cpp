// Photographs taken by our own renderer with known cameras, and what they show.
#include "mq/draw/photograph.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "atlas/atlas_fixtures.h"
#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/draw/render.h"
#include "mq/fem/texel_space.h"

namespace mq {
namespace {

/// A sphere whose colour is linear in space, photographed without light from two sides.
TEST(Projector, FindsTheColoursOfWhatIsSeen) {
  const Surface surface = make_surface(fixtures::sphere(5));
  std::vector<float> colours;
  const auto colour = [](const Vector3& p, int k) { return 0.5 + 0.3 * p[k]; };
  for (const Vector3& p : surface.mesh.positions)
    for (int k = 0; k < 3; ++k) colours.push_back(float(colour(p, k)));
  const Renderer renderer(surface);
  RenderOptions options;
  options.width = options.height = 400;
  options.paint = RenderOptions::Paint::vertex_colours;
  options.light = RenderOptions::Light::none;
  const std::vector<Vector3>& places = surface.mesh.positions;
  const Projector projector(surface, places, 0.02);
  std::vector<Partial> partials;
  for (const char* view : {"front", "back"}) {
    options.view = parse_view(view);
    const Image<float> picture = renderer.draw({.vertex_values = colours}, options);
    const PinholeCamera camera = pinhole_of(Camera(surface.mesh, options.view, 400, 400));
    partials.push_back(projector.project(camera, picture));
    const Vector3 towards = camera.center().normalized();
    const double distance = camera.center().norm();
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double confidence = partials.back().confidence[i];
      // Beyond the horizon nothing is seen, well within it everything.
      const double height = places[i].dot(towards);
      if (height < 1 / distance) {
        EXPECT_EQ(confidence, 0) << i;
      }
      if (height > 0.6) {
        EXPECT_GT(confidence, 0.05) << i;
      }
      if (confidence == 0) continue;
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(partials.back().values(Eigen::Index(i), k), colour(places[i], k), 0.01);
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_EQ(std::min(partials[0].confidence[i], partials[1].confidence[i]), 0);
}

/// A small square in front of a large one: its shadow is not seen, what is beside it is.
TEST(Projector, KnowsWhatIsHidden) {
  Mesh wall = fixtures::flat_square(20), screen = fixtures::flat_square(2);
  for (Vector3& p : screen.positions) p = 0.2 * p + Vector3(0.4, 0.4, 0.5);
  for (Mesh* mesh : {&wall, &screen}) mesh->uvs.clear(), mesh->corner_uvs.clear();
  const Surface surface = make_surface(fixtures::beside(wall, screen));
  PinholeCamera camera{.width = 200, .height = 200, .fx = 300, .fy = 300, .cx = 100, .cy = 100};
  camera.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()).toRotationMatrix();
  camera.translation = -camera.rotation * Vector3(0.5, 0.5, 2);  // looks down from z = 2
  const Projector projector(surface, surface.mesh.positions, 0.05);
  const Partial partial = projector.project(camera, Image<float>(200, 200, 4, 0.5F));
  EXPECT_EQ(partial.values.cols(), 3);
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    const Vector3& p = surface.mesh.positions[v];
    // The shadow of the screen at z = 0.5 on the wall: 2 / 1.5 as large.
    const double from = std::max(std::abs(p.x() - 0.5), std::abs(p.y() - 0.5));
    const bool on_screen = p.z() > 0.1;
    if (!on_screen && from < 0.13) {
      EXPECT_EQ(partial.confidence[v], 0) << p.transpose();
    }
    if (!on_screen && from > 0.15 && from < 0.45) {
      EXPECT_GT(partial.confidence[v], 0) << p.transpose();
    }
    if (on_screen && from < 0.09) {
      EXPECT_GT(partial.confidence[v], 0) << p.transpose();
    }
  }
  EXPECT_FALSE(
      fixtures::error_of([&] { projector.project(camera, Image<float>(10, 10, 3)); }).empty());
}

}  // namespace
}  // namespace mq
