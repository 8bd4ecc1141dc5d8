// Distances for a source that moves: they end where `GeodesicDistance` ends.

#include "mq/filter/live_geodesic.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "filter/geodesic_squares.h"
#include "fixtures.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using LiveMethod = LiveGeodesicOptions::Method;
using LivePart = LiveGeodesicStep::Part;

/// A front on a level below the unknowns.
constexpr LiveGeodesicOptions coarse_front{.most_front_nodes = 4000};

struct DraggedSquare {
  fixtures::Cut cut;
  TexelSpace space;

  explicit DraggedSquare(const fixtures::CutOptions& options, int side = 128)
      : cut(fixtures::cut("dragged", options, {side, side})), space(cut.model->surface, cut.model->atlas) {}

  /// The unknown nearest to a place, and the place.
  std::vector<GeodesicSource> at(double x, double y) const {
    const Vector3 place(x, y, 0);
    return {{fixtures::nearest(space.texels(), place), 0, place}};
  }
  double spacing() const { return space.scale().texel_spacing; }
};

int steps_to_rest(LiveGeodesic& live) {
  int steps = 0;
  while (!live.rests() && steps < 1000) live.step(), ++steps;
  return steps;
}

/// Mean and largest difference.
std::pair<double, double> difference(const Vector& a, const Vector& b) {
  const Vector d = (a - b).cwiseAbs();
  return {d.mean(), d.maxCoeff()};
}

TEST(LiveGeodesic, EndsWhereGeodesicDistanceEnds) {
  for (const fixtures::CutOptions& options : {fixtures::whole_square(), fixtures::four_charts()}) {
    const DraggedSquare square(options);
    LiveGeodesic live(square.space, coarse_front);
    const GeodesicDistance exact(square.space);
    for (const auto& [x, y] : {std::pair(0.41, 0.53), std::pair(0.437, 0.551), std::pair(0.12, 0.8)}) {
      live.move(square.at(x, y));
      EXPECT_LT(steps_to_rest(live), 60);
      const auto [mean, most] = difference(live.distance(), exact.from(square.at(x, y)).distance);
      // Sweeps that begin elsewhere stop within the same tolerance elsewhere: found were 0.065 spacings on average.
      EXPECT_LT(mean, 0.1 * square.spacing()) << x;
      EXPECT_LT(most, 1.0 * square.spacing()) << x;
    }
  }
}

TEST(LiveGeodesic, ShowsDistancesToAFewPerCentAtOnce) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic live(square.space, coarse_front);
  const GeodesicDistance exact(square.space);
  for (const auto& [x, y] : {std::pair(0.41, 0.53), std::pair(0.9, 0.2), std::pair(0.13, 0.71)}) {
    live.move(square.at(x, y));
    EXPECT_EQ(live.step().part, LivePart::front);
    const Vector distance = exact.from(square.at(x, y)).distance;
    const auto [mean, most] = difference(live.distance(), distance);
    EXPECT_LT(mean, 0.02 * distance.mean()) << x;
    EXPECT_LT(most, 0.06 * distance.maxCoeff()) << x;
  }
}

TEST(LiveGeodesic, GetsBetterWithEveryLook) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic live(square.space, coarse_front);
  const Vector exact = GeodesicDistance(square.space).from(square.at(0.4, 0.45)).distance;
  live.move(square.at(0.4, 0.45));
  double first = 0, last = 0;
  while (!live.rests()) {
    if (live.step().shown == LiveGeodesicStep::Shown::as_before) continue;
    last = difference(live.distance(), exact).first;
    if (first == 0) first = last;
    EXPECT_LT(last, 1.001 * first);
  }
  EXPECT_LT(last, 0.2 * first);
}

TEST(LiveGeodesic, FollowsASourceThatMovesAndNothingElse) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic live(square.space, coarse_front);
  live.move(square.at(0.3, 0.3));
  live.step();
  const Vector before = live.distance();
  live.move(square.at(0.6, 0.6));
  EXPECT_TRUE(live.distance() == before);  // until the next step
  live.step();
  // A source that is at d moves no distance by more than d, and that of its old place by about d.
  const double moved = std::hypot(0.3, 0.3);
  const auto [mean, most] = difference(live.distance(), before);
  EXPECT_NEAR(most, moved, 0.05 * moved);
  EXPECT_GT(mean, 0.3 * moved);
}

/// Whatever happened before.
TEST(LiveGeodesic, DoesNotRememberEarlierSources) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic fresh(square.space, coarse_front), used(square.space, coarse_front);
  used.move(square.at(0.7, 0.2));
  for (int k = 0; k < 7; ++k) used.step();
  for (LiveGeodesic* live : {&fresh, &used}) {
    live->move(square.at(0.3, 0.6));
    steps_to_rest(*live);
  }
  EXPECT_TRUE(fresh.distance() == used.distance());
}

TEST(LiveGeodesic, TakesPointsBetweenTexelsAndAtSeams) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic live(square.space, coarse_front);
  // The charts' seams cross near the middle; a third of a texel apart, distances differ by so much.
  for (const double shift : {0.0, 0.31, 0.64}) {
    const Vector3 place(0.5 + shift * square.spacing(), 0.5, 0);
    live.move({{fixtures::nearest(square.space.texels(), place), 0, place}});
    live.step();
    double worst = 0;
    for (int i = 0; i < square.space.size(); ++i) {
      const Vector3 p = fixtures::position(square.space.texels(), i);
      if ((p - place).norm() < 8 * square.spacing())
        worst = std::max(worst, std::abs(live.distance()[i] - (p - place).norm()));
    }
    EXPECT_LT(worst, 0.5 * square.spacing()) << shift;
  }
}

TEST(LiveGeodesic, IsThatToTheNearestOfManySources) {
  const DraggedSquare square(fixtures::whole_square());
  LiveGeodesic live(square.space, coarse_front);
  std::vector<GeodesicSource> all = square.at(0.2, 0.3), other = square.at(0.8, 0.7);
  all.push_back(other.front());
  live.move(all);
  live.step();
  const Vector both = live.distance();
  live.move(square.at(0.2, 0.3));
  live.step();
  const Vector one = live.distance();
  live.move(other);
  live.step();
  // Nodes five spacings apart cut the corner where both meet.
  const auto [mean, most] = difference(both, one.cwiseMin(live.distance()));
  EXPECT_LT(mean, 0.5 * square.spacing());
  EXPECT_LT(most, 10 * square.spacing());
}

TEST(LiveGeodesic, IsInfiniteWhereNoPathLeads) {
  const Mesh torn = fixtures::torn(fixtures::cut_square(fixtures::four_charts()));
  const auto model = fixtures::textured(torn, {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  const Vector exact = GeodesicDistance(space).from({{3, 0}}).distance;
  ASSERT_TRUE(std::isinf(exact.maxCoeff()));
  for (const LiveMethod method : {LiveMethod::progressive, LiveMethod::published}) {
    LiveGeodesicOptions options = coarse_front;
    options.method = method, options.most_front_nodes = 500;
    LiveGeodesic live(space, options);
    live.move({{3, 0}});
    for (int k = 0; k < 12; ++k) {
      live.step();
      for (int i = 0; i < space.size(); ++i)
        ASSERT_EQ(std::isfinite(live.distance()[i]), std::isfinite(exact[i])) << i << " after " << k;
    }
  }
}

TEST(LiveGeodesic, WorksAtVertices) {
  const Surface sphere = make_surface(fixtures::cut_sphere(32, fixtures::CutOptions{}));
  const VertexSpace space(sphere);
  LiveGeodesicOptions options;
  options.most_front_nodes = space.size() / 3;
  LiveGeodesic live(space, options);
  live.move({{5, 0}});
  live.step();
  const Vector exact = GeodesicDistance(space).from({{5, 0}}).distance;
  EXPECT_LT(difference(live.distance(), exact).first, 0.04 * exact.mean());
  steps_to_rest(live);
  EXPECT_LT(difference(live.distance(), exact).first, 0.005 * exact.mean());
}

/// Figure 5.17: three cycles on each equation are as good as a solution.
TEST(LiveGeodesic, PublishedEndsAfterThreeCycles) {
  const DraggedSquare square(fixtures::four_charts());
  LiveGeodesic live(square.space, {.method = LiveMethod::published});
  live.move(square.at(0.4, 0.45));
  std::vector<Vector> shown;
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(live.step().part, LivePart::published);
    shown.push_back(live.distance());
  }
  const Vector& end = shown.back();
  const auto rms = [&](std::size_t k) { return std::sqrt((shown[k] - end).squaredNorm() / double(end.size())); };
  EXPECT_GT(rms(0), 5e-4 * end.maxCoeff());  // one is not enough
  EXPECT_LT(rms(2), 1e-3 * end.maxCoeff());
  EXPECT_LT(rms(5), 1e-4 * end.maxCoeff());
  // So long a time rounds off, most at boundaries.
  const auto [mean, most] = difference(end, GeodesicDistance(square.space).from(square.at(0.4, 0.45)).distance);
  EXPECT_LT(mean, 0.08 * end.mean());
}

TEST(LiveGeodesic, HasTheSameBitsForAnyNumberOfThreads) {
  const DraggedSquare square(fixtures::four_charts(), 256);
  for (const LiveMethod method : {LiveMethod::progressive, LiveMethod::published}) {
    std::vector<Vector> found;
    for (const int threads : {1, 2, 3}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
      LiveGeodesicOptions options = coarse_front;
      options.method = method;
      LiveGeodesic live(square.space, options);
      live.move(square.at(0.31, 0.62));
      for (int k = 0; k < 8; ++k) live.step();
      live.move(square.at(0.33, 0.6));
      for (int k = 0; k < 12; ++k) live.step();
      found.push_back(live.distance());
    }
    EXPECT_TRUE(found[0] == found[1]);
    EXPECT_TRUE(found[0] == found[2]);
  }
}

TEST(LiveGeodesic, RefusesSourcesThatAreNone) {
  const DraggedSquare square(fixtures::whole_square(), 64);
  for (const LiveMethod method : {LiveMethod::progressive, LiveMethod::published}) {
    LiveGeodesic live(square.space, {.method = method});
    EXPECT_THROW(live.step(), InvalidInput);  // there is no source yet
    EXPECT_EQ(live.distance().size(), 0);
    EXPECT_THROW(live.move({}), InvalidInput);
    EXPECT_THROW(live.move({{square.space.size(), 0}}), InvalidInput);
    EXPECT_THROW(live.move({{-1, 0}}), InvalidInput);
    EXPECT_THROW(live.move({{0, -1}}), InvalidInput);
    EXPECT_THROW(live.move({{0, std::numeric_limits<double>::quiet_NaN()}}), InvalidInput);
    live.move(square.at(0.5, 0.5));
    live.step();
    const Vector before = live.distance();
    EXPECT_THROW(live.move({{-1, 0}}), InvalidInput);
    EXPECT_TRUE(live.distance() == before);
    live.step();
    EXPECT_GT(live.distance().maxCoeff(), 0.5);
  }
  EXPECT_THROW(LiveGeodesic(square.space, {.geodesic = {.time = 0}}), InvalidInput);
  EXPECT_THROW(LiveGeodesic(square.space, {.published_alpha = -1}), InvalidInput);
}

}  // namespace
}  // namespace mq
