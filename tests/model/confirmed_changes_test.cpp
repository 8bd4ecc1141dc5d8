#include "mq/model/confirmed_changes.h"

#include <gtest/gtest.h>

#include "fixtures.h"
#include "model/sequences.h"
#include "mq/sample/cheap_capture.h"

namespace mq {
namespace {

/// A sheet that was a template, and a frame with the same vertices, of which some are seeds.
struct Sheet {
  Surface surface = make_surface(fixtures::flat_square(40), {.kind = WeldOptions::Kind::none});

  std::vector<char> over_hole = std::vector<char>(surface.mesh.positions.size(), 1);

  /// All vertices within this of a place.
  RemeshSeeds seeds(const Vector2& of_template, const Vector2& of_target, double radius) const {
    RemeshSeeds found;
    const auto& positions = surface.mesh.positions;
    for (const Vector3& p : positions) {
      found.of_template.push_back((p.head<2>() - of_template).norm() < radius);
      found.of_target.push_back((p.head<2>() - of_target).norm() < radius);
    }
    found.on_template = ClosestPointFinder(surface.mesh)(positions);
    return found;
  }
};

const Vector2 here(0.25, 0.25), there(0.75, 0.75), nowhere(9, 9);

TEST(ConfirmedChanges, AreThoseThatAllFramesAfterAskFor) {
  const Sheet sheet;
  const RemeshSeeds both = sheet.seeds(here, there, 0.12);
  const SeedPlaces again = places_of(both, sheet.surface, 2);
  const SeedPlaces first = places_of(sheet.seeds(here, nowhere, 0.12), sheet.surface, 2);
  EXPECT_EQ(passing_places(both, sheet.surface, sheet.over_hole, {}).seeds, 0);
  EXPECT_EQ(passing_places(both, sheet.surface, sheet.over_hole, {again, again}).seeds, 0);
  const PassingPlaces found = passing_places(both, sheet.surface, sheet.over_hole, {again, first});
  EXPECT_GT(found.seeds, 0);
  EXPECT_EQ(found.asked, std::ranges::count(both.of_template, char(1)));
  EXPECT_EQ(found.seeds, std::ranges::count(both.of_target, char(1)));
  for (std::size_t v = 0; v < both.of_template.size(); ++v) {
    if (both.of_template[v]) {
      EXPECT_FALSE(found.of_template[v]);
    }
    if (both.of_target[v]) {
      EXPECT_TRUE(found.of_target[v]);
      EXPECT_TRUE(found.pulled[v]);
    }
  }
}

TEST(ConfirmedChanges, WaitWhereSomethingElsePassesBesideThem) {
  const Sheet sheet;
  const RemeshSeeds both = sheet.seeds(here, here, 0.12);
  const SeedPlaces one = places_of(sheet.seeds(here, nowhere, 0.12), sheet.surface, 2);
  EXPECT_EQ(passing_places(both, sheet.surface, sheet.over_hole, {one}).asked, 0);
  const SeedPlaces other = places_of(sheet.seeds(nowhere, here, 0.12), sheet.surface, 2);
  EXPECT_EQ(passing_places(both, sheet.surface, sheet.over_hole, {other}).asked, 0);
}

TEST(ConfirmedChanges, WhatIsGoneButNotOverAHoleIsSoAtOnce) {
  const Sheet sheet;
  const RemeshSeeds gone = sheet.seeds(here, nowhere, 0.12);
  const SeedPlaces none = places_of(sheet.seeds(nowhere, nowhere, 0.12), sheet.surface, 2);
  EXPECT_EQ(passing_places(gone, sheet.surface, sheet.over_hole, {none}).asked, 0);
  const std::vector<char> over_none(sheet.over_hole.size(), 0);
  EXPECT_EQ(passing_places(gone, sheet.surface, over_none, {none}).seeds, 0);
}

/// A body that bends a little, with a hole of the capture's in some frames.
std::vector<MemoryFrames::Frame> with_hole(int count, int first, int last) {
  std::vector<MemoryFrames::Frame> frames = bending(count);
  for (int f = first; f <= last; ++f) {
    Mesh& mesh = frames[f].model.mesh;
    const Vector3 place = moved_material("bending", {0.05, -0.3, 0.3}, f);
    const std::vector<char> left = left_by_holes(mesh, {place}, 0.2);
    std::vector<Triangle> rest;
    for (std::size_t t = 0; t < left.size(); ++t)
      if (left[t]) rest.push_back(mesh.triangles[t]);
    mesh.triangles = rest;
  }
  return frames;
}

/// Frames in which segments begin, counted from 0.
std::vector<int> segment_starts(const std::vector<MemoryFrames::Frame>& made, int confirming) {
  const MemoryFrames frames(made);
  MemoryStore store;
  SequenceTracker(
      frames, store,
      coarse({.follow = {.remeshing = Remeshing::parts, .confirming_frames = confirming}}))
      .run();
  std::vector<int> starts;
  const auto& all = store.mesh().frames;
  for (int f = 1; f < std::ssize(all); ++f)
    if (all[f].segment != all[f - 1].segment) starts.push_back(f);
  return starts;
}

TEST(ConfirmedChanges, HolesThatComeAndGoAreNotFollowed) {
  EXPECT_FALSE(segment_starts(with_hole(5, 1, 1), 0).empty());
  EXPECT_TRUE(segment_starts(with_hole(5, 1, 1), 1).empty());
}

TEST(ConfirmedChanges, HolesThatStayAreFollowedAtOnce) {
  const std::vector<int> starts = segment_starts(with_hole(5, 1, 4), 2);
  ASSERT_FALSE(starts.empty());
  EXPECT_EQ(starts[0], 1);
}

/// A sequence with a hole in its last frame, and whether something passed before.
enum class Before { clean, noisy };
std::vector<MemoryFrames::Frame> with_hole_at_the_end(Before before) {
  std::vector<MemoryFrames::Frame> frames = with_hole(6, 5, 5);
  if (before == Before::noisy)
    for (const int f : {1, 3}) frames[std::size_t(f)] = with_hole(6, f, f)[std::size_t(f)];
  return frames;
}

TEST(ConfirmedChanges, OfTheLastFramesAreNotMadeWhereSomethingPassedBefore) {
  EXPECT_EQ(segment_starts(with_hole_at_the_end(Before::clean), 2), std::vector<int>{5});
  EXPECT_TRUE(segment_starts(with_hole_at_the_end(Before::noisy), 2).empty());
}

TEST(ConfirmedChanges, AreRememberedByAStore) {
  const MemoryFrames frames(with_hole_at_the_end(Before::noisy));
  const auto options = coarse({.follow = {.remeshing = Remeshing::parts, .confirming_frames = 2}});
  MemoryStore store;
  const FollowedSequence whole = SequenceTracker(frames, store, options).run();
  EXPECT_GT(whole.frames[1].passing, 0);
  EXPECT_EQ(whole.frames[2].passing, 0);
  EXPECT_GT(whole.frames[3].passing, 0);
  store.go_on(5);
  SequenceTrackerOptions resuming = options;
  resuming.resume = SequenceTrackerOptions::Resume::where_possible;
  const FollowedSequence resumed = SequenceTracker(frames, store, resuming).run();
  EXPECT_EQ(without_seconds(resumed.frames), without_seconds(whole.frames));
}

TEST(ConfirmedChanges, OfOneMeshThatMovesNothingPasses) {
  std::vector<MemoryFrames::Frame> frames = with_hole(5, 1, 2);
  EXPECT_TRUE(segment_starts(frames, 3).empty());
  frames[2].model = frames[1].model;
  const std::vector<int> starts = segment_starts(frames, 3);
  ASSERT_FALSE(starts.empty());
  EXPECT_EQ(starts[0], 1);
}

}  // namespace
}  // namespace mq
