// What parts of a sequence say of its motion, and a sequence that is followed along them.
#include "mq/model/known_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "evolving/evolving_models.h"
#include "io/folder.h"
#include "model/sequences.h"
#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/mesh/surface.h"
#include "mq/model/sequence_tracker.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class StoredParts : public FolderTest {
 protected:
  /// Follows frames by themselves: `count` of them from `first` on.
  fs::path follow_part(const std::vector<MemoryFrames::Frame>& frames, int first, int count, const std::string& name,
                       const SequenceTrackerOptions& options) const {
    EvolvingStore store(folder / name);
    const MemoryFrames part({frames.begin() + first, frames.begin() + first + count});
    SequenceTracker(part, store, options).run();
    return folder / name;
  }
};

template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST_F(StoredParts, MovePointsOfTheSurfaceAsTheSurfaceMoved) {
  const std::vector<Vector3> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EvolvingMesh square;
  square.segments.push_back(segment_of({corners, {{0, 1, 2}, {0, 2, 3}}, {}, {}, {}}));
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Vector3 away(2, 0, 3);
  square.frames = {{4, 0, corners}, {6, 0, corners}};
  for (Vector3& p : square.frames[1].positions) p = turn * p + away;
  write_evolving(folder / "part.evolving", square, 1.0 / 1024);

  const StoredMotion motion({folder / "part.evolving"});
  const std::vector<Vector3> points = {{0.25, 0.5, 0}, {1, 1, 0}, {0.5, 0.25, 0.125}};
  const auto moved = motion.moved(4, 6, points);
  ASSERT_TRUE(moved);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(((*moved)[i] - turn * points[i] - away).norm(), 1e-12) << i;
  // What is off the surface moves by as much as the point below it.
  EXPECT_LT(((*moved)[2] - turn * Vector3(0.5, 0.25, 0) - away - Vector3(0, 0, 0.125)).norm(), 1e-12);
  EXPECT_TRUE(motion.has(4));
  EXPECT_FALSE(motion.has(5));
  EXPECT_FALSE(motion.moved(6, 4, points));
  EXPECT_FALSE(motion.moved(6, 7, points));
}

/// A sheet that waves, of which a part made triangles anew in frame 3, and a vertex in the middle, as they were distorted
/// or too far from what was captured.
TEST_F(StoredParts, MoveWhatWasDistortedAsWhatIsAroundItAndKnowNothingOfWhatCame) {
  EvolvingMesh sheet = patched_sheet(20, 2, 5);
  constexpr int gone = 10 * 21 + 10;
  sheet.segments[1].vertex_ids[gone] = 5000;
  const auto moved_where = [&](const FollowedFrame::Replacement& replaced) {
    std::vector<std::string> measured(sheet.frames.size());
    FollowedFrame found;
    found.match = FollowedFrame::Match{};
    found.replaced = replaced;
    measured[3] = followed_text(found);
    write_evolving(folder / "sheet.evolving", sheet, store_step(20), "{}", measured);
    const StoredMotion motion({folder / "sheet.evolving"});
    EXPECT_TRUE(motion.moved(1, 2, sheet.frames[1].positions));
    return motion.moved(2, 3, sheet.frames[2].positions);
  };
  const auto &before = sheet.frames[2], &after = sheet.frames[3];
  ASSERT_NE(before.segment, after.segment);
  const auto moved = moved_where({.distorted = 7});
  ASSERT_TRUE(moved);
  const double far = (after.positions[gone] - before.positions[gone]).norm();
  ASSERT_GT(far, 0.1);
  for (int v = 0; v < std::ssize(before.positions); ++v)
    EXPECT_LT(((*moved)[v] - after.positions[v]).norm(), v == gone ? 0.05 * far : 1e-4) << v;
  EXPECT_FALSE(moved_where({.distorted = 7, .template_seeds = 1}));
  EXPECT_FALSE(moved_where({.distorted = 7, .target_seeds = 1}));
}

TEST_F(StoredParts, AreJoinedToWhatOneRunFollows) {
  const std::vector<MemoryFrames::Frame> all = bending(9);
  SequenceTrackerOptions options = coarse({.follow = {.truth = Truth::material}});
  const MemoryFrames frames(all);
  MemoryStore whole, joined;
  const auto in_one = SequenceTracker(frames, whole, options).run().frames;
  const auto first = follow_part(all, 0, 4, "first.evolving", options),
             second = follow_part(all, 4, 5, "second.evolving", options);
  options.follow.motion = std::make_shared<StoredMotion>(std::vector{first, second});
  const auto in_parts = SequenceTracker(frames, joined, options).run().frames;
  ASSERT_EQ(in_parts.size(), 9U);
  EXPECT_EQ(joined.mesh().segments.size(), 1U);
  EXPECT_EQ(joined.mesh().segments[0].triangles, whole.mesh().segments[0].triangles);
  for (std::size_t f = 1; f < in_parts.size(); ++f) {
    EXPECT_EQ(in_parts[f].match->known, f != 4) << f;
    EXPECT_LT(in_parts[f].distance.p95, 1.2 * in_one[f].distance.p95) << f;
    EXPECT_LT(in_parts[f].drift->mean_edges, in_one[f].drift->mean_edges + 0.1) << f;
    EXPECT_EQ(in_parts[f].folded, 0) << f;
  }

  // Stopped and gone on with, it is the same.
  options.resume = SequenceTrackerOptions::Resume::where_possible;
  MemoryStore again = joined;
  again.go_on(6);
  SequenceTracker(frames, again, options).run();
  for (std::size_t f = 0; f < 9; ++f)
    EXPECT_EQ(again.mesh().frames[f].positions, joined.mesh().frames[f].positions) << f;
}

/// Parts that were followed by shape take a vase that turns for one at rest.
TEST_F(StoredParts, AreCorrectedByColoursWhereTheyAreJoined) {
  const std::vector<MemoryFrames::Frame> all = moving_frames("spinning", 0, 7, {.triangles = 1000});
  SequenceTrackerOptions options = coarse({.follow = {.truth = Truth::material}});
  const auto first = follow_part(all, 0, 4, "first.evolving", options),
             second = follow_part(all, 4, 4, "second.evolving", options);
  options.follow.motion = std::make_shared<StoredMotion>(std::vector{first, second});
  const auto joined = [&](TemplateFollowerOptions::Colours colours) {
    options.follow.colours = colours;
    MemoryStore store;
    return SequenceTracker(MemoryFrames(all), store, options).run().frames;
  };
  const auto by_shape = joined(TemplateFollowerOptions::Colours::left),
             by_colour = joined(TemplateFollowerOptions::Colours::used);
  for (std::size_t f = 1; f < all.size(); ++f) {
    EXPECT_EQ(by_colour[f].match->known, f != 4) << f;
    EXPECT_LT(by_colour[f].drift->mean_edges, 0.75 * by_shape[f].drift->mean_edges) << f;
    EXPECT_LT(by_colour[f].distance.p95, 1.2 * by_shape[f].distance.p95) << f;
  }
  EXPECT_LT(by_colour.back().drift->mean_edges, 0.25 * by_shape.back().drift->mean_edges);
}

TEST_F(StoredParts, LetTrianglesLiveOnFromPartToPartWhereBodiesMerge) {
  const std::vector<MemoryFrames::Frame> all = merging(9, 14);
  SequenceTrackerOptions options = coarse({.follow = {.remeshing = Remeshing::parts}});
  const auto first = follow_part(all, 0, 3, "first.evolving", options),
             second = follow_part(all, 3, 3, "second.evolving", options);
  options.follow.motion = std::make_shared<StoredMotion>(std::vector{first, second});
  MemoryStore joined;
  const auto found = SequenceTracker(MemoryFrames(all), joined, options).run().frames;
  int added = 0;
  for (std::size_t f = 1; f < found.size(); ++f) {
    added += found[f].added;
    EXPECT_LT(found[f].distance.p95, 0.002) << f;
    EXPECT_GT(found[f].kept, 9 * found[f].added) << f;
    EXPECT_EQ(found[f].folded, 0) << f;
  }
  EXPECT_GT(added, 0);
  EXPECT_EQ(make_surface(joined.mesh().mesh(0)).components, 2);
  EXPECT_EQ(make_surface(joined.mesh().mesh(5)).components, 1);
}

TEST_F(StoredParts, AreRefusedWithGapsOrFramesTwiceOrOfOtherFiles) {
  const std::vector<MemoryFrames::Frame> all = bending(6);
  SequenceTrackerOptions options = coarse();
  const auto first = follow_part(all, 0, 2, "first.evolving", options),
             last = follow_part(all, 4, 2, "last.evolving", options),
             wide = follow_part(all, 1, 2, "wide.evolving", options);
  options.follow.motion = std::make_shared<StoredMotion>(std::vector{first, last});
  MemoryStore store;
  EXPECT_THAT(refusal([&] { SequenceTracker(MemoryFrames(all), store, options).run(); }),
              HasSubstr("2 frames are in no part, from number 2 to 3"));
  EXPECT_TRUE(store.frames().empty());
  EXPECT_THAT(refusal([&] { StoredMotion({first, wide}); }), HasSubstr("frame 1 is in " + first.string() + " too"));
  put("first.blocks", get("first.blocks").substr(0, get("first.blocks").size() - 3));
  EXPECT_THAT(refusal([&] { StoredMotion({first}); }), HasSubstr("make it again"));
  // Of frames in memory no files are known.
  EXPECT_THAT(refusal([&] { options.follow.motion->require_made_of(4, {{"frame_4.ply", {17, 3}}}); }), "");
}

}  // namespace
}  // namespace mq
