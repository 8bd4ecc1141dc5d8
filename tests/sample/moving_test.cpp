#include "mq/sample/moving.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

const MovingOptions coarse{.period = 100, .triangles = 2500};

TEST(Moving, KnowsWhereMaterialIsInEveryFrame) {
  for (const SampleInfo& info : moving_names())
    for (const int frame : {0, 13, 50, 77}) {
      const MovingFrame made = make_moving_frame(info.name, frame, coarse);
      ASSERT_GT(made.mesh.triangle_count(), 1500) << info.name;
      for (int v = 0; v < made.mesh.vertex_count(); ++v)
        ASSERT_LT(
            (moved_material(info.name, made.material[v], frame, coarse) - made.mesh.positions[v])
                .norm(),
            1e-12)
            << info.name << " " << frame;
    }
}

TEST(Moving, HasSoundMeshesThatAreOthersInEveryFrame) {
  for (const SampleInfo& info : moving_names()) {
    const MovingFrame first = make_moving_frame(info.name, 20, coarse);
    const MovingFrame second = make_moving_frame(info.name, 21, coarse);
    EXPECT_TRUE(make_surface(first.mesh).defects.empty()) << info.name;
    EXPECT_EQ(make_surface(first.mesh).boundary_edges, 0);
    EXPECT_NE(first.mesh.triangles, second.mesh.triangles) << info.name;
  }
}

TEST(Moving, LiesAtRestInFrameZero) {
  const MovingFrame bending = make_moving_frame("bending", 0, coarse);
  for (int v = 0; v < bending.mesh.vertex_count(); ++v)
    EXPECT_LT((bending.material[v] - bending.mesh.positions[v]).norm(), 1e-12);
}

TEST(Moving, SpinsWithoutChangingItsShape) {
  const MovingFrame made = make_moving_frame("spinning", 30, coarse);
  double moved = 0;
  for (int v = 0; v < made.mesh.vertex_count(); ++v) {
    const Vector3 p = made.mesh.positions[v], m = made.material[v];
    EXPECT_NEAR(std::hypot(p.x(), p.z()), std::hypot(m.x(), m.z()), 1e-12);
    EXPECT_NEAR(p.y(), m.y(), 1e-12);
    moved = std::max(moved, (p - m).norm());
  }
  EXPECT_GT(moved, 0.5);
}

TEST(Moving, MergesTwoBallsAndPartsThem) {
  const auto components = [](int frame) {
    return make_surface(make_moving_frame("merging", frame, coarse).mesh).components;
  };
  EXPECT_EQ(components(0), 2);
  EXPECT_EQ(components(50), 1);
  EXPECT_EQ(components(99), 2);
}

TEST(Moving, IsLitFromOneSideThatGoesAround) {
  MovingOptions lit = coarse;
  lit.light = 0.5;
  const auto shade = [&](int frame, const Vector3& side) {
    const MovingFrame dark = make_moving_frame("spinning", frame, lit),
                      plain = make_moving_frame("spinning", frame, coarse);
    EXPECT_EQ(dark.mesh.positions, plain.mesh.positions);
    double sum = 0, all = 0;
    for (int v = 0; v < dark.mesh.vertex_count(); ++v) {
      if (dark.mesh.positions[v].dot(side) < 0.3) continue;
      sum += dark.colors[v].sum();
      all += plain.colors[v].sum();
    }
    return sum / all;
  };
  EXPECT_GT(shade(0, {1, 0, 0}), 0.85);
  EXPECT_LT(shade(0, {-1, 0, 0}), 0.65);
  EXPECT_LT(shade(light_period / 2, {1, 0, 0}), 0.65);
  EXPECT_GT(shade(light_period / 2, {-1, 0, 0}), 0.85);
}

TEST(Moving, HasNoiseOfTheDeviationAskedFor) {
  MovingOptions noisy = coarse;
  noisy.noise = 0.02;
  const MovingFrame made = make_moving_frame("bending", 3, noisy),
                    plain = make_moving_frame("bending", 3, coarse);
  double sum = 0;
  for (int v = 0; v < made.mesh.vertex_count(); ++v)
    sum += (made.colors[v] - plain.colors[v]).squaredNorm() / (3 * made.mesh.vertex_count());
  EXPECT_NEAR(std::sqrt(sum), 0.02, 0.001);
}

/// Logarithms of exposure at vertices of frame f that no channel clips.
std::vector<double> exposures(const MovingOptions& options, int f) {
  const MovingFrame made = make_moving_frame("bending", f, options), plain = make_moving_frame("bending", f, coarse);
  EXPECT_EQ(made.mesh.positions, plain.mesh.positions);
  std::vector<double> result;
  for (int v = 0; v < made.mesh.vertex_count(); ++v)
    if (plain.colors[v].minCoeff() > 0.05 && plain.colors[v].maxCoeff() < 0.75)
      result.push_back(std::log(made.colors[v].x() / plain.colors[v].x()));
  return result;
}

TEST(Moving, FlickersByTheDeviationAskedForAnotherInEveryFrame) {
  MovingOptions flickering = coarse;
  flickering.flicker = 0.06;
  double squares = 0, count = 0, whole = 0, frames = 0;
  for (int f = 0; f < 50; ++f) {
    double sum = 0;
    const std::vector<double> found = exposures(flickering, f);
    for (const double x : found) squares += x * x, sum += x, ++count;
    whole += sum / double(found.size()) * sum / double(found.size()), ++frames;
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.06, 0.006);
  // A third is alike everywhere, and a little of the rest is left in the mean.
  EXPECT_GT(whole / frames, 0.25 * 0.06 * 0.06);
  EXPECT_LT(whole / frames, 0.7 * 0.06 * 0.06);
}

TEST(Moving, FlickersSmoothlyOverTheSurface) {
  MovingOptions flickering = coarse;
  flickering.flicker = 0.06;
  const MovingFrame made = make_moving_frame("bending", 5, flickering), plain = make_moving_frame("bending", 5, coarse);
  const auto exposure = [&](int v) { return std::log(made.colors[v].y() / plain.colors[v].y()); };
  double steps = 0, count = 0, edges = 0;
  for (const Triangle& t : plain.mesh.triangles) {
    if (std::ranges::any_of(t, [&](int v) { return plain.colors[v].minCoeff() < 0.05 || plain.colors[v].maxCoeff() > 0.75; }))
      continue;
    const double step = exposure(t[0]) - exposure(t[1]);
    steps += step * step, ++count;
    edges += (plain.mesh.positions[t[0]] - plain.mesh.positions[t[1]]).squaredNorm();
  }
  // Waves have a slope of 2π / length at most, and cameras change within the turn of a normal.
  EXPECT_LT(std::sqrt(steps / count), 0.06 * 2 * std::numbers::pi / flicker_wave * std::sqrt(edges / count));
}

TEST(Moving, RefusesWhatThereIsNot) {
  EXPECT_THROW(make_moving_frame("bendign", 0), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", -1), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", 0, {.period = 0}), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", 0, {.triangles = 10}), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", 0, {.light = 2}), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", 0, {.noise = -1}), InvalidInput);
  EXPECT_THROW(make_moving_frame("bending", 0, {.flicker = -1}), InvalidInput);
}

TEST(Moving, IsOffByWhatIsAskedFor) {
  MovingOptions off = coarse;
  off.capture.off = 0.3;
  const MovingFrame made = make_moving_frame("bending", 5, off),
                    clean = make_moving_frame("bending", 5, coarse);
  ASSERT_EQ(made.mesh.triangles, clean.mesh.triangles);
  EXPECT_EQ(made.material, clean.material);
  double squares = 0;
  for (int v = 0; v < made.mesh.vertex_count(); ++v)
    squares += (made.mesh.positions[v] - clean.mesh.positions[v]).squaredNorm();
  const double edge = mean_edge_length(make_surface(clean.mesh));
  // Along the normal, and a quarter of it in each of three directions.
  const double expected = 0.3 * edge * std::sqrt(1 + 3.0 / 16);
  EXPECT_NEAR(std::sqrt(squares / made.mesh.vertex_count()), expected, 0.03 * expected);
  EXPECT_EQ(make_moving_frame("bending", 5, off).mesh.positions, made.mesh.positions);
}

TEST(Moving, HasHolesAndHandlesThatComeAndGo) {
  MovingOptions flickering = coarse;
  flickering.capture = {.holes = 1, .handles = 1};
  for (const int frame : {3, 4}) {
    const MovingFrame made = make_moving_frame("bending", frame, flickering);
    const Surface surface = make_surface(made.mesh);
    EXPECT_TRUE(surface.defects.empty());
    EXPECT_GT(surface.boundary_edges, 5);
    EXPECT_EQ(surface.euler_characteristic, 2 - 1 - 2);
    EXPECT_EQ(made.material.size(), made.mesh.positions.size());
    EXPECT_EQ(made.colors.size(), made.mesh.positions.size());
  }
  const auto places = [](int frame) {
    const MovingFrame clean = make_moving_frame("bending", frame, coarse);
    std::vector<Vector3> found;
    for (const int v : flickering_vertices(clean.material, 1, frame, 1))
      found.push_back(clean.material[v]);
    return found[0];
  };
  EXPECT_LT((places(2) - places(3)).norm(), 0.1);
  EXPECT_GT((places(3) - places(4)).norm(), 0.1);
}

}  // namespace
}  // namespace mq
