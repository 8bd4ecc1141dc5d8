#include "mq/model/sequence_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "model/sequences.h"
#include "mq/base/error.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

using testing::HasSubstr;
using BadFrames = SequenceTrackerOptions::BadFrames;
using Resume = SequenceTrackerOptions::Resume;

void expect_same(const MemoryStore& store, const MemoryStore& other) {
  ASSERT_EQ(store.mesh().segments.size(), other.mesh().segments.size());
  ASSERT_EQ(store.mesh().frames.size(), other.mesh().frames.size());
  for (std::size_t s = 0; s < store.mesh().segments.size(); ++s) {
    EXPECT_EQ(store.mesh().segments[s].triangles, other.mesh().segments[s].triangles) << s;
    EXPECT_EQ(store.mesh().segments[s].triangle_ids, other.mesh().segments[s].triangle_ids) << s;
    EXPECT_EQ(store.mesh().segments[s].vertex_ids, other.mesh().segments[s].vertex_ids) << s;
  }
  for (std::size_t f = 0; f < store.mesh().frames.size(); ++f)
    EXPECT_EQ(store.mesh().frames[f].positions, other.mesh().frames[f].positions) << f;
  EXPECT_EQ(without_seconds(store.frames()), without_seconds(other.frames()));
}

std::string refusal(const FrameLoader& frames, SequenceStore& store,
                    const SequenceTrackerOptions& options) {
  try {
    SequenceTracker(frames, store, options).run();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(SequenceTracker, FollowsASequenceAndSaysHowWell) {
  const MemoryFrames frames(bending(3));
  MemoryStore store;
  const FollowedSequence found =
      SequenceTracker(frames, store, coarse({.follow = {.truth = Truth::material}})).run();
  ASSERT_EQ(found.frames.size(), 3U);
  EXPECT_EQ(found.frames[2].kept, found.frames[0].added);
  EXPECT_EQ(found.frames[2].added, 0);
  EXPECT_GT(found.frames[2].distance.p95, 0);
  EXPECT_LT(found.frames[2].distance.p95, 0.005);
  EXPECT_LT(found.frames[0].drift->mean_edges, 1e-3);
  EXPECT_LT(found.frames[2].drift->mean_edges, 1);
  EXPECT_TRUE(found.frames[0].is_own());
  EXPECT_GT(found.frames[2].match->seconds.total, 0);
  EXPECT_EQ(store.mesh().segments.size(), 1U);
  EXPECT_EQ(store.mesh().frames[2].number, 2);
  EXPECT_FALSE(first_lost(found.frames));
}

TEST(SequenceTracker, ResumesWhereItWasStopped) {
  const MemoryFrames frames(bending(4));
  SequenceTrackerOptions options = coarse(
      {.follow = {.truth = Truth::material, .colours = TemplateFollowerOptions::Colours::used}});
  MemoryStore whole, part;
  SequenceTracker(frames, whole, options).run();
  Stopper stopper("frame 2");
  Heard heard;
  EXPECT_THROW(SequenceTracker(frames, part, options, heard).run(stopper.progress()), Cancelled);
  ASSERT_EQ(part.frames().size(), 2U);
  EXPECT_THAT(heard.safe_now, HasSubstr("has 2 of 4 frames, and resume goes on from there"));
  options.resume = Resume::where_possible;
  const FollowedSequence found = SequenceTracker(frames, part, options, heard).run();
  EXPECT_THAT(heard.remarks, HasSubstr("goes on after frame 1"));
  EXPECT_EQ(found.frames.size(), 4U);
  expect_same(part, whole);
}

TEST(SequenceTracker, RemeshesWhereBodiesMergeAndResumesAfterThat) {
  const MemoryFrames frames(merging(10, 13));
  SequenceTrackerOptions options =
      coarse({.follow = {.remeshing = Remeshing::parts, .truth = Truth::material}});
  MemoryStore whole;
  const FollowedSequence found = SequenceTracker(frames, whole, options).run();
  int added = 0;
  for (std::size_t f = 1; f < found.frames.size(); ++f) {
    const FollowedFrame& frame = found.frames[f];
    added += frame.added;
    EXPECT_EQ(frame.replaced.has_value(), frame.added > 0) << f;
    EXPECT_LT(frame.distance.p95, 0.002) << f;
    EXPECT_LT(frame.distance.max, 0.01) << f;
    EXPECT_GT(frame.kept, frame.removed) << f;
    EXPECT_EQ(frame.manifold, true) << f;
    EXPECT_EQ(frame.folded, 0) << f;
  }
  EXPECT_GT(added, 0);
  ASSERT_GT(whole.mesh().segments.size(), 1U);
  EXPECT_EQ(make_surface(whole.mesh().mesh(0)).components, 2);
  EXPECT_EQ(make_surface(whole.mesh().mesh(3)).components, 1);
  int throughout = 0;
  for (const Lifespan& span : triangle_lifespans(whole.mesh()))
    throughout += span.first == 0 && span.last == 3;
  EXPECT_GT(throughout, whole.mesh().segments[0].triangle_count() / 2);

  options.resume = Resume::where_possible;
  MemoryStore part = whole;
  part.go_on(3);
  SequenceTracker(frames, part, options).run();
  expect_same(part, whole);
}

TEST(SequenceTracker, TakesKeyframesInsteadOfParts) {
  const MemoryFrames frames(merging(10, 12));
  MemoryStore parts, wholes;
  const auto in_parts =
      SequenceTracker(frames, parts, coarse({.follow = {.remeshing = Remeshing::parts}}))
          .run()
          .frames;
  const auto as_wholes =
      SequenceTracker(frames, wholes, coarse({.follow = {.remeshing = Remeshing::keyframes}}))
          .run()
          .frames;
  // Up to the first both are the same template.
  std::size_t first = 1;
  while (first < 3 && in_parts[first].added == 0) ++first;
  ASSERT_LT(first, 3U);
  EXPECT_GT(in_parts[first].kept, 0);
  EXPECT_EQ(as_wholes[first].kept, 0);
  EXPECT_EQ(as_wholes[first].removed, as_wholes[0].added);
  EXPECT_TRUE(as_wholes[first].is_own());
  EXPECT_TRUE(as_wholes[first].match.has_value());
}

TEST(SequenceTracker, BeginsAnewWhereATemplateNoLongerFits) {
  const MemoryFrames frames(bending(3));
  MemoryStore store;
  const auto found =
      SequenceTracker(frames, store, coarse({.follow = {.restart = 1e-7}})).run().frames;
  EXPECT_EQ(found[1].removed, found[0].added);
  EXPECT_EQ(store.mesh().segments.size(), 3U);
  for (const Lifespan& span : triangle_lifespans(store.mesh())) EXPECT_EQ(span.first, span.last);
}

TEST(SequenceTracker, CutsTrianglesThatAreLongBesideTheWayFromNodeToNode) {
  const MemoryFrames frames(moving_frames("bending", 0, 1, {.triangles = 500}));
  MemoryStore store;
  SequenceTrackerOptions options{.follow = {.truth = Truth::material}};
  options.follow.track.node_spacing = 0.1;
  const FollowedFrame frame = SequenceTracker(frames, store, options).run().frames[1];
  EXPECT_GT(frame.kept, 2 * 492);
  EXPECT_LT(frame.distance.p95, 0.005);  // 0.0100 with the triangles as they come
  EXPECT_GT(frame.drift->known, 900);    // vertices; 247 as they come
}

/// Flips every `step`-th triangle.
void flip(Model& model, int step) {
  std::vector<int> some;
  for (int t = 0; t < model.mesh.triangle_count(); t += step) some.push_back(t);
  model.mesh = with_flipped(std::move(model.mesh), some);
}

TEST(SequenceTracker, TurnsBackWhatFacesTheWrongWay) {
  for (const Remeshing remeshing : {Remeshing::none, Remeshing::parts}) {
    std::vector<MemoryFrames::Frame> made = bending(3);
    const SequenceTrackerOptions options =
        coarse({.follow = {.remeshing = remeshing, .truth = Truth::material}});
    MemoryStore sound, turned;
    SequenceTracker(MemoryFrames(made), sound, options).run();
    flip(made[0].model, 17);  // some of the first, all of the third
    flip(made[2].model, 1);
    Heard heard;
    const MemoryFrames flipped(made);
    const FollowedSequence found = SequenceTracker(flipped, turned, options, heard).run();
    for (int f = 0; f < 3; ++f)
      EXPECT_EQ(turned.mesh().frames[f].positions, sound.mesh().frames[f].positions);
    EXPECT_THAT(heard.warnings, HasSubstr("frame 0: "));
    EXPECT_THAT(heard.warnings, HasSubstr("frame 2: "));
    ASSERT_EQ(found.defects.size(), 2U);
    EXPECT_EQ(found.defects[0].kind, "turned_triangles");
    EXPECT_EQ(found.defects[1].kind, "inside_out_triangles");
    EXPECT_GT(found.frames[0].turned, 10);
    EXPECT_EQ(found.frames[1].turned, 0);
    EXPECT_GT(found.frames[2].turned, 900);
  }
}

TEST(SequenceTracker, SaysFromWhichFrameOnSomethingIsWrong) {
  std::vector<MemoryFrames::Frame> made = bending(2);
  Mesh& mesh = made[1].model.mesh;
  Triangle fin = mesh.triangles.front();  // a third triangle at an edge
  fin[2] = mesh.vertex_count();
  mesh.positions.emplace_back(0, 0, 1);
  mesh.triangles.push_back(fin);
  made[1].model.colors.values.resize(3 * mesh.positions.size());
  MemoryStore store;
  Heard heard;
  const MemoryFrames frames(made);
  const Defects found = SequenceTracker(frames, store, coarse(), heard).run().defects;
  const auto crowded = std::ranges::find(found, "nonmanifold_edges", &Defect::kind);
  ASSERT_NE(crowded, found.end());
  EXPECT_THAT(crowded->message, HasSubstr("frame 1: "));
  EXPECT_THAT(heard.warnings, HasSubstr("frame 1: "));
}

/// Frames of which some cannot be read, and some are not there.
class BadFiles : public MemoryFrames {
 public:
  BadFiles(std::vector<Frame> frames, std::set<int> bad, std::vector<int> missing = {})
      : MemoryFrames(std::move(frames)), bad_(std::move(bad)), missing_(std::move(missing)) {}
  Model read(int frame) const override {
    if (bad_.contains(number(frame))) throw IoError("the file ends after 7 bytes");
    return MemoryFrames::read(frame);
  }
  std::vector<int> missing_before(int frame) const override {
    return frame == count() ? missing_ : std::vector<int>();
  }

 private:
  std::set<int> bad_;
  std::vector<int> missing_;
};

TEST(SequenceTracker, LeavesOutBadFramesIfItMay) {
  std::vector<MemoryFrames::Frame> made = bending(5);
  for (Vector3& p : made[4].model.mesh.positions) p.setZero();
  const BadFiles frames(made, {0, 2}, {5, 6});
  MemoryStore store;
  SequenceTrackerOptions options = coarse();
  EXPECT_THAT(refusal(frames, store, options),
              testing::AllOf(HasSubstr("frame 0: the file ends after 7 bytes"),
                             HasSubstr("; or leave out such frames with bad_frames")));
  EXPECT_TRUE(store.frames().empty());

  options.bad_frames = BadFrames::left_out;
  Heard heard;
  const FollowedSequence found = SequenceTracker(frames, store, options, heard).run();
  EXPECT_THAT(heard.warnings, HasSubstr("frame 0: the file ends after 7 bytes; it is left out"));
  ASSERT_EQ(found.frames.size(), 2U);
  EXPECT_EQ(found.frames[1].number, 3);
  std::vector<int> skipped;
  for (const SkippedFrame& one : found.skipped) skipped.push_back(one.number);
  EXPECT_EQ(skipped, (std::vector{0, 2, 4, 5, 6}));
  EXPECT_THAT(found.skipped[2].why, HasSubstr("no triangle with an area"));
  EXPECT_THAT(found.skipped[3].why, HasSubstr("the sequence: there is no frame 5"));

  // A run that was stopped goes on with the same result, and one that was not has it still.
  options.resume = Resume::where_possible;
  for (const int kept : {1, 2}) {
    MemoryStore part = store;
    part.go_on(kept);
    EXPECT_EQ(SequenceTracker(frames, part, options).run().skipped.size(), 5U);
    expect_same(part, store);
  }
  options.bad_frames = BadFrames::refused;
  EXPECT_THAT(refusal(frames, store, options), HasSubstr("give bad_frames if it was left out"));
  options = coarse({.bad_frames = BadFrames::left_out});
  EXPECT_THAT(refusal(BadFiles(made, {0, 1, 2, 3}), store, options),
              HasSubstr("not one of the frames can be followed"));
}

TEST(SequenceTracker, FollowsAnewWhatCanBeReadNow) {
  const std::vector<MemoryFrames::Frame> made = bending(3);
  MemoryStore store, whole;
  const SequenceTrackerOptions options =
      coarse({.bad_frames = BadFrames::left_out, .resume = Resume::where_possible});
  SequenceTracker(BadFiles(made, {1}), store, options).run();
  ASSERT_EQ(store.frames().size(), 2U);
  Heard heard;
  const MemoryFrames mended(made);
  SequenceTracker(mended, store, options, heard).run();
  EXPECT_THAT(heard.remarks, HasSubstr("frame 1 is not in the store, and can be followed now"));
  SequenceTracker(mended, whole, options).run();
  expect_same(store, whole);
  // Of another beginning nothing is kept, so it is not given up without being asked for.
  MemoryStore late;
  SequenceTracker(BadFiles(made, {0}), late, options).run();
  EXPECT_THAT(refusal(mended, late, options), HasSubstr("can be followed now and comes first"));
}

/// Frames whose files are others now.
class ChangedFiles : public MemoryFrames {
 public:
  ChangedFiles(std::vector<Frame> frames, int changed)
      : MemoryFrames(std::move(frames)), changed_(changed) {}
  bool is_changed(int frame, const std::vector<KnownFile>&) const override {
    return number(frame) == changed_;
  }

 private:
  int changed_;
};

TEST(SequenceTracker, ResumesBeforeWhatWasChanged) {
  const std::vector<MemoryFrames::Frame> made = bending(3);
  MemoryStore store;
  const SequenceTrackerOptions options = coarse({.resume = Resume::where_possible});
  SequenceTracker(MemoryFrames(made), store, options).run();
  const MemoryStore whole = store;
  Heard heard;
  const ChangedFiles second(made, 1), first(made, 0);
  SequenceTracker(second, store, options, heard).run();
  EXPECT_THAT(heard.remarks, HasSubstr("frame 1 was changed since it was followed"));
  EXPECT_THAT(heard.remarks, HasSubstr("goes on after frame 0"));
  expect_same(store, whole);
  EXPECT_THAT(refusal(first, store, options),
              HasSubstr("frame 0 is not the mesh that it was made of; track without resume"));
  // Frames of another sequence.
  const MemoryFrames others(std::vector(made.begin() + 1, made.end()));
  EXPECT_THAT(refusal(others, store, options), HasSubstr("its frame 0 is not one of these frames"));
  expect_same(store, whole);
}

TEST(SequenceTracker, RefusesAStoreThatDoesNotSayHowItWasFollowed) {
  const std::vector<MemoryFrames::Frame> made = bending(1);
  MemoryStore whole, store;
  SequenceTracker(MemoryFrames(made), whole).run();
  store.begin(whole.step());
  store.add_segment(whole.mesh().segments[0]);
  store.add_frame(followed_frame(0, ""), whole.mesh().frames[0].positions);
  EXPECT_THAT(refusal(MemoryFrames(made), store, {.resume = Resume::where_possible}),
              HasSubstr("does not say how its frame 0 was followed"));
}

/// Counts what is read.
class CountedFrames : public MemoryFrames {
 public:
  using MemoryFrames::MemoryFrames;
  Model read(int frame) const override { return ++frames_read, MemoryFrames::read(frame); }
  Mesh material(int frame) const override {
    return ++materials_read, MemoryFrames::material(frame);
  }
  mutable int frames_read = 0, materials_read = 0;
};

TEST(SequenceTracker, ReadsFramesAndTheirTruthOnce) {
  const CountedFrames frames(merging(10, 12));
  MemoryStore store;
  SequenceTracker(frames, store,
                  coarse({.follow = {.remeshing = Remeshing::parts, .truth = Truth::material}}))
      .run();
  EXPECT_GT(store.mesh().segments.size(), 1U);
  EXPECT_EQ(frames.frames_read, 3);
  EXPECT_EQ(frames.materials_read, 3);
}

TEST(SequenceTracker, RefusesATruthThatIsNotThere) {
  std::vector<MemoryFrames::Frame> made = bending(1);
  MemoryStore store;
  const SequenceTrackerOptions options{.follow = {.truth = Truth::material}};
  EXPECT_THAT(refusal(MemoryFrames(made), store, {.follow = {.truth = Truth::uvs}}),
              HasSubstr("truth uv wants texture coordinates, and it has none"));
  made[0].material.clear();
  EXPECT_THAT(refusal(MemoryFrames(made), store, options),
              HasSubstr("frame 0: it is not known where its material is at rest"));
  made[0].model.colors = {};
  EXPECT_THAT(refusal(MemoryFrames(made), store,
                      {.follow = {.colours = TemplateFollowerOptions::Colours::used}}),
              HasSubstr("colours wants colours at vertices or a texture, and it has neither"));
}

TEST(SequenceTracker, RehearsesWithoutWriting) {
  std::vector<MemoryFrames::Frame> made = bending(2);
  MemoryStore store;
  const MemoryFrames frames(made);
  SequenceTracker(frames, store).rehearse();
  EXPECT_TRUE(store.frames().empty());
  made[0].model.mesh.triangles.clear();
  const MemoryFrames empty(made);
  EXPECT_THROW(SequenceTracker(empty, store).rehearse(), InvalidInput);
}

TEST(FirstLost, TellsApartWhereAllAndWhereFewPointsAreLost) {
  FollowedFrame fits, few, all;
  fits.distance = {0.001, 0.002, 0.04};
  few.number = 7, few.distance = {0.001, 0.002, 0.06};
  all.number = 8, all.distance = {0.01, 0.02, 0.03};
  EXPECT_FALSE(first_lost({fits}));
  EXPECT_EQ(first_lost({fits, few, all})->number, 7);
  EXPECT_EQ(first_lost({fits, few, all})->extent, LostFrame::Extent::few);
  EXPECT_EQ(first_lost({fits, all, few})->extent, LostFrame::Extent::many);
}

}  // namespace
}  // namespace mq
