// Patches of labels, cells of outlines, and what an atlas says of itself.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fixtures.h"
#include "mq/base/random.h"
#include "mq/base/stopwatch.h"
#include "mq/unwrap/detail/chart_patches.h"
#include "mq/unwrap/detail/pack_shape.h"
#include "mq/unwrap/unwrap.h"

namespace mq {
namespace {

/// Two labels, left and right of the middle of a square.
struct TwoHalves {
  Surface surface = make_surface(fixtures::flat_square(12, 0.1));
  std::vector<int> labels;
  TwoHalves() {
    for (int t = 0; t < surface.triangle_count(); ++t) labels.push_back(middle(t).x() < 0.5 ? 0 : 1);
  }
  Vector3 middle(int t) const {
    return (surface.mesh.position(t, 0) + surface.mesh.position(t, 1) + surface.mesh.position(t, 2)) / 3;
  }
  /// Sides at which the labels differ.
  int border(const std::vector<int>& of) const {
    int sides = 0;
    for (std::size_t h = 0; h < surface.twins.size(); ++h)
      if (const HalfEdge twin = surface.twins[h]; twin > HalfEdge(h)) sides += of[h / 3] != of[twin / 3];
    return sides;
  }
};

TEST(Patches, OfTwoHalvesAreTheseAndKeepTheirNames) {
  const TwoHalves halves;
  const SurfacePatches found = make_discs(halves.surface, halves.labels);
  EXPECT_EQ(found.count, 2);
  for (std::size_t t = 0; t < halves.labels.size(); ++t)
    EXPECT_EQ(found.sources[found.patch[t]], halves.labels[t]) << t;
}

/// Triangles whose corner stands into another patch, which has all others around it.
int teeth(const Surface& surface, const std::vector<int>& patch) {
  std::map<int, std::vector<int>> around;
  std::vector<char> on_border(surface.mesh.positions.size(), 0);
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      around[surface.mesh.triangles[t][k]].push_back(t);
      if (surface.twins[3 * t + k] < 0)
        for (const int v : {surface.mesh.triangles[t][k], surface.mesh.triangles[t][(k + 1) % 3]}) on_border[v] = 1;
    }
  int found = 0;
  for (const auto& [v, triangles] : around)
    for (const int t : triangles) {
      const int k = int(std::ranges::find(surface.mesh.triangles[t], v) - surface.mesh.triangles[t].begin());
      const HalfEdge base = surface.twins[3 * t + (k + 1) % 3];
      if (on_border[v] || base < 0 || patch[base / 3] != patch[t]) continue;
      const int into = patch[triangles[triangles[0] == t ? 1 : 0]];
      found += into != patch[t] &&
               std::ranges::all_of(triangles, [&](int other) { return other == t || patch[other] == into; });
    }
  return found;
}

TEST(Patches, NoTriangleStandsIntoAnother) {
  const Surface surface = make_surface(fixtures::flat_square(24, 0.2));
  int before = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Random random(seed);
    std::vector<int> labels;
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 middle = (surface.mesh.position(t, 0) + surface.mesh.position(t, 1) + surface.mesh.position(t, 2)) / 3;
      labels.push_back(int(3 * std::clamp(middle.x() + 0.3 * std::sin(7 * middle.y() + double(seed)) +
                                              random.uniform(std::uint64_t(t), -0.1, 0.1),
                                          0.0, 0.99)));
    }
    before += teeth(surface, labels);
    const SurfacePatches found = make_discs(surface, labels);
    EXPECT_EQ(teeth(surface, found.patch), 0) << seed;
  }
  EXPECT_GT(before, 100);
}

TEST(Patches, OfALabelTheLargestPieceStays) {
  const TwoHalves halves;
  std::vector<int> labels = halves.labels;
  // Islands of two triangles in either half, before and after its own half in the file's order.
  int islands = 0;
  for (int t = 0; t + 1 < halves.surface.triangle_count(); t += 2)
    if (std::abs(halves.middle(t).x() - 0.5) > 0.3 && std::abs(halves.middle(t).y() - 0.5) < 0.4 && (t / 2) % 5 == 0) {
      labels[t] = 1 - labels[t], labels[t + 1] = labels[t];
      ++islands;
    }
  ASSERT_GT(islands, 5);
  const SurfacePatches found = make_discs(halves.surface, labels);
  EXPECT_EQ(found.count, 2);
  for (std::size_t t = 0; t < labels.size(); ++t) EXPECT_EQ(found.sources[found.patch[t]], halves.labels[t]) << t;
}

/// Whether a segment meets a box.
bool meets(const Vector2& a, const Vector2& b, const Vector2& low, const Vector2& high) {
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double d = b[axis] - a[axis];
    if (d == 0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) return false;
      continue;
    }
    const double s = (low[axis] - a[axis]) / d, t = (high[axis] - a[axis]) / d;
    from = std::max(from, std::min(s, t)), to = std::min(to, std::max(s, t));
  }
  return from <= to;
}

bool contains(const std::vector<Vector2>& polygon, const Vector2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      inside = !inside;
  }
  return inside;
}

TEST(PackShape, TouchesTheCellsThatAnOutlineMadeWiderMeets) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Random random(seed);
    PackChart chart;
    chart.loops = {{}};
    for (int k = 0; k < 5; ++k) {  // around a middle, so that it does not meet itself
      const double angle = 2 * M_PI * (k + 0.6 * random.uniform(2 * k)) / 5, radius = 2 + 4 * random.uniform(2 * k + 1);
      chart.loops[0].push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    for (const double pad : {0.0, 0.3, 1.7}) {
      constexpr double scale = 1.3;
      const PackShape shape = make_shape(chart, 0, scale, pad, 0);
      std::vector<Vector2> polygon;
      for (const Vector2& p : chart.loops[0]) polygon.push_back(scale * p - shape.origin);
      std::map<std::pair<int, int>, bool> touched;
      for (const CellRun& run : shape.touched)
        for (int x = run.begin; x < run.end; ++x) touched[{x, run.row}] = true;
      for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
          const Vector2 low(x - pad, y - pad), high(x + 1 + pad, y + 1 + pad);
          bool wanted = contains(polygon, {x + 0.5, y + 0.5});
          for (std::size_t i = 0; i < polygon.size(); ++i)
            wanted |= meets(polygon[i], polygon[(i + 1) % polygon.size()], low, high);
          const bool found = touched.contains({x, y});
          ASSERT_EQ(found, wanted) << seed << ", " << pad << ": " << x << ", " << y;
        }
    }
  }
}

constexpr UnwrapOptions one_chart{.width = 256, .height = 256, .stretch = 2, .trials = 3, .largest = 1};

TEST(UnwrapFigures, SeamsAreTheEdgesAtWhichCoordinatesDiffer) {
  for (const Mesh& mesh : {fixtures::sphere(3), fixtures::torus(24, 12), fixtures::flat_square(8, 0.2)}) {
    const Surface surface = make_surface(mesh);
    const Unwrapped found = unwrap(surface, {.width = 256, .height = 256, .trials = 3});
    double length = 0;
    for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
      const HalfEdge twin = surface.twins[h];
      if (twin < h) continue;
      const int a = found.corner_uvs[h / 3][h % 3], b = found.corner_uvs[h / 3][(h + 1) % 3];
      const int c = found.corner_uvs[twin / 3][(twin + 1) % 3], d = found.corner_uvs[twin / 3][twin % 3];
      if (a == c && b == d) continue;
      length += (surface.mesh.position(h / 3, h % 3) - surface.mesh.position(h / 3, (h + 1) % 3)).norm();
    }
    EXPECT_NEAR(found.figures.seam_length, length / std::sqrt(surface.area), 1e-6);
  }
}

TEST(UnwrapFigures, AFlatSurfaceIsOneChartWithoutSeams) {
  const Unwrapped found = unwrap(make_surface(fixtures::flat_square(10, 0.2)), one_chart);
  EXPECT_EQ(found.figures.charts, 1);
  EXPECT_EQ(found.figures.seam_length, 0);
  EXPECT_NEAR(found.figures.stretch.l2_stretch, 1, 1e-6);
}

TEST(UnwrapFigures, SecondsAddUpToTheWhole) {
  const Surface surface = make_surface(fixtures::sphere(3));
  const Stopwatch watch;
  const Unwrapped found = unwrap(surface, one_chart);
  double sum = 0;
  for (const auto& lap : found.figures.seconds) {
    EXPECT_GE(lap.seconds, 0) << lap.step;
    sum += lap.seconds;
  }
  EXPECT_GT(sum, 0);
  EXPECT_LE(sum, watch.seconds());
}

}  // namespace
}  // namespace mq
