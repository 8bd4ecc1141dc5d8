#include "mq/baseline/keyframes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using Parts = std::vector<ComponentShape>;

Mesh moved(Mesh mesh, double by, double scale = 1) {
  for (Vector3& p : mesh.positions) p = scale * p + Vector3(by, 0, 0);
  return mesh;
}

TEST(ComponentShapes, KnowSpheresFromTori) {
  const Mesh ball = fixtures::sphere(3), ring = moved(fixtures::torus(20, 12), 5);
  const Surface both = make_surface(fixtures::beside(ball, ring));
  const Parts parts = component_shapes(both);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].genus, 1);  // 4 π² R r = 15.8 is more than 4 π
  EXPECT_EQ(parts[1].genus, 0);
  EXPECT_NEAR(parts[0].area, total_area(ring), 1e-12);
  EXPECT_NEAR(parts[1].area, total_area(ball), 1e-12);
}

TEST(ComponentShapes, CloseHolesAndCountHandlesAlone) {
  // A disc, a torus without a triangle, one without two that are apart, and both apart in one surface.
  const auto without = [](Mesh mesh, std::vector<int> triangles) {
    std::ranges::sort(triangles, std::ranges::greater{});
    for (const int t : triangles) {
      mesh.triangles.erase(mesh.triangles.begin() + t);
      if (!mesh.corner_uvs.empty()) mesh.corner_uvs.erase(mesh.corner_uvs.begin() + t);
    }
    return mesh;
  };
  const Mesh ring = fixtures::torus(20, 12);
  EXPECT_EQ(component_shapes(make_surface(fixtures::flat_square(4)))[0].genus, 0);
  for (const std::vector<int>& holes : {std::vector<int>{7}, {7, 200}, {7, 100, 200, 300}})
    EXPECT_EQ(component_shapes(make_surface(without(ring, holes)))[0].genus, 1) << holes.size();
  const Parts two = component_shapes(
      make_surface(fixtures::beside(without(ring, {7, 200}), moved(without(fixtures::sphere(3), {1, 60, 100}), 5))));
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(two[0].genus, 1);
  EXPECT_EQ(two[1].genus, 0);
}

TEST(ComponentShapes, DoNotTakeCollapsedTrianglesForHoles) {
  // As exporters that round leave them: an edge of three triangles, one of which uses a vertex twice.
  Mesh ring = fixtures::torus(20, 12);
  ring.corner_uvs.clear();
  const Triangle t = ring.triangles[7];
  ring.triangles.push_back({t[0], t[1], t[0]});
  ring.triangles.push_back({t[2], t[2], t[2]});
  const Parts parts = component_shapes(make_surface(ring));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].genus, 1);
}

TEST(ComponentShapes, LeaveOutWhatIsTiny) {
  const Surface surface =
      make_surface(fixtures::beside(fixtures::sphere(3), moved(fixtures::sphere(1), 5, 0.02)));
  EXPECT_EQ(component_shapes(surface).size(), 1U);
  EXPECT_EQ(component_shapes(surface, 1e-5).size(), 2U);
}

TEST(KeyframeScores, PutComponentsBeforeGenusBeforeArea) {
  const std::vector<Parts> frames = {{{0, 4}},           // one ball
                                     {{0, 2}, {0, 2}},   // two of half the area
                                     {{1, 4}},           // a ring
                                     {{0, 5}}};          // a larger ball
  const std::vector<double> scores = keyframe_scores(frames);
  EXPECT_DOUBLE_EQ(scores[0], 1 + 1 + 0.4);
  EXPECT_DOUBLE_EQ(scores[1], 2 * (1 + 1 + 0.2));
  EXPECT_DOUBLE_EQ(scores[2], 1 + 0 + 0.4);
  EXPECT_DOUBLE_EQ(scores[3], 1 + 1 + 0.5);
}

TEST(KeyframeScores, AreTheSameForEveryUnit) {
  std::vector<Parts> frames = {{{0, 4}}, {{2, 3}, {0, 2}}, {{1, 4}, {1, 1}, {0, 1}}, {}};
  const std::vector<double> scores = keyframe_scores(frames);
  for (Parts& parts : frames)
    for (ComponentShape& part : parts) part.area *= 0x1p20;
  EXPECT_EQ(keyframe_scores(frames), scores);
  EXPECT_EQ(scores[3], 0);
}

/// A keyframe shows frames at most so far from it.
FollowKeyframe within(int frames) {
  return [frames](int keyframe, int first, int last) {
    return KeyframeRange{keyframe, std::max(first, keyframe - frames), std::min(last, keyframe + frames)};
  };
}

TEST(Keyframes, AreTheBestFramesAndAsFewAsCanBeWhereThesePartTheSequence) {
  // Every seventh from the third on is best: with a reach of three these alone show all of 21 frames.
  std::vector<double> scores(21, 1.0);
  for (const int best : {3, 10, 17}) scores[best] = 2;
  const std::vector<KeyframeRange> ranges = choose_keyframes(scores, within(3));
  ASSERT_EQ(ranges.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(ranges[i].keyframe, 3 + 7 * i);
    EXPECT_EQ(ranges[i].first, 7 * i);
    EXPECT_EQ(ranges[i].last, 7 * i + 6);
  }
}

TEST(Keyframes, NeedOneWhereItShowsAll) {
  const std::vector<double> scores = {1, 2, 5, 2, 1, 0};
  const std::vector<KeyframeRange> ranges = choose_keyframes(scores, within(10));
  ASSERT_EQ(ranges.size(), 1U);
  EXPECT_EQ(ranges[0].keyframe, 2);
  EXPECT_EQ(ranges[0].first, 0);
  EXPECT_EQ(ranges[0].last, 5);
}

TEST(Keyframes, ShowEveryFrameOnceAndNoneIsBetterThanItsOwn) {
  const Random random(3);
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    const int count = 1 + int(40 * random.uniform(1000 * trial));
    std::vector<double> scores;
    for (int f = 0; f < count; ++f)
      scores.push_back(std::floor(5 * random.uniform(1000 * trial + std::uint64_t(f) + 1)));
    const auto follow = [&](int keyframe, int first, int last) {
      const auto draw = [&](int side) {
        return random.uniform(1000 * trial + 100 + 2 * std::uint64_t(keyframe) + std::uint64_t(side));
      };
      return KeyframeRange{keyframe, keyframe - int(draw(0) * (keyframe - first + 1)),
                           keyframe + int(draw(1) * (last - keyframe + 1))};
    };
    int next = 0;
    for (const KeyframeRange& range : choose_keyframes(scores, follow)) {
      EXPECT_EQ(range.first, next);
      EXPECT_LE(range.first, range.keyframe);
      EXPECT_LE(range.keyframe, range.last);
      for (int f = range.first; f <= range.last; ++f) EXPECT_LE(scores[f], scores[range.keyframe]);
      next = range.last + 1;
    }
    EXPECT_EQ(next, count);
  }
  EXPECT_TRUE(choose_keyframes({}, within(1)).empty());
}

TEST(Keyframes, RefuseRangesThatLeaveWhatWasAskedFor) {
  const std::vector<double> scores = {1, 2, 3};
  const auto found = [](KeyframeRange range) { return [range](int, int, int) { return range; }; };
  EXPECT_NO_THROW(choose_keyframes(scores, found({2, 0, 2})));
  EXPECT_THROW(choose_keyframes(scores, found({2, 0, 3})), InvalidInput);
  EXPECT_THROW(choose_keyframes(scores, found({2, -1, 2})), InvalidInput);
  EXPECT_THROW(choose_keyframes(scores, found({2, 0, 1})), InvalidInput);
  EXPECT_THROW(choose_keyframes(scores, found({1, 0, 2})), InvalidInput);
  const std::vector<double> bad = {1, std::numeric_limits<double>::quiet_NaN()};
  EXPECT_THROW(choose_keyframes(bad, within(1)), InvalidInput);
}

}  // namespace
}  // namespace mq
