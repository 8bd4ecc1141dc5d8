#include "mq/io/followed_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace mq {
namespace {

using testing::HasSubstr;

FollowedFrame own_frame() {
  FollowedFrame frame;
  frame.number = 4;
  frame.distance = {0.125, 0.25, 0.5};
  frame.distortion = {1, 1};
  frame.kept = 0, frame.added = 12, frame.removed = 3;
  frame.manifold = true;
  frame.folded = 0;
  frame.seconds = 1.5;
  return frame;
}

FollowedFrame remeshed_frame() {
  FollowedFrame frame = own_frame();
  frame.turned = 2;
  frame.skipped = {{3, "the file ends"}};
  frame.distortion = {1, 1.0625};
  frame.kept = 9;
  frame.match = FollowedFrame::Match{0.75, true, true, true, {1, 2, 3, 4, 5, 6}, 0.5};
  frame.replaced = FollowedFrame::Replacement{1, 2, 3, 4, 5};
  frame.passing = 6;
  frame.drift = FollowedFrame::Drift{{7, 0.25, 0.5, 0.75}, 2};
  frame.files = {{"frame_4.ply", {70, 4000000000U}}};
  return frame;
}

TEST(FollowedFrame, IsWrittenInTheOrderOfTheFormat) {
  EXPECT_EQ(followed_text(own_frame()),
            R"({"frame":4,"distance_mean":0.125,"distance_p95":0.25,"distance_max":0.5,)"
            R"("triangles_kept":0,"triangles_born":12,"triangles_died":3,)"
            R"("distortion_mean":1,"distortion_p95":1,"manifold":true,"folded":0,"files":[],)"
            R"("seconds":{"all":1.5}})");
  EXPECT_EQ(followed_text(remeshed_frame()),
            R"({"frame":4,"turned":2,"skipped":[{"frame":3,"why":"the file ends"}],)"
            R"("distance_mean":0.125,"distance_p95":0.25,"distance_max":0.5,)"
            R"("distortion_mean":1.0,"distortion_p95":1.0625,"matched":0.75,"predicted":true,)"
            R"("recognised":true,"known_motion":true,"seconds":{"correspond":1.0,"solve":2.0,"colour":3.0,"snap":4.0,"measure":5.0,)"
            R"("total":6.0,"remesh":0.5,"all":1.5},)"
            R"("triangles_kept":9,"triangles_died":3,"triangles_born":12,)"
            R"("replaced":{"distorted":1,"template_seeds":2,"target_seeds":3,"reached":4,)"
            R"("rounds":5},"passing":6,"manifold":true,"folded":0,)"
            R"("drift":{"known":7,"mean":0.25,"p95":0.5,"max":0.75,"mean_edges":2.0},)"
            R"("files":[{"file":"frame_4.ply","bytes":70,"crc32":4000000000}]})");
}

TEST(FollowedFrame, IsReadAsItWasWritten) {
  FollowedFrame keyframe = remeshed_frame();  // followed first, then replaced as a whole
  keyframe.replaced.reset();
  keyframe.kept = 0;
  keyframe.distortion = {1, 1};
  for (const FollowedFrame& frame : {own_frame(), remeshed_frame(), keyframe}) {
    const std::string text = followed_text(frame);
    EXPECT_EQ(followed_text(followed_frame(4, text)), text);
  }
  EXPECT_EQ(followed_frame(4, followed_text(remeshed_frame())).files[0].print,
            (FilePrint{70, 4000000000U}));
}

TEST(FollowedFrame, DoesNotKnowWhatAStoreDoesNotSay) {
  for (const char* text : {"", "{", "[1]", "{}", R"({"distance_p95":"far","files":3})"}) {
    const FollowedFrame frame = followed_frame(7, text);
    EXPECT_EQ(frame.number, 7) << text;
    EXPECT_TRUE(std::isnan(frame.distance.p95)) << text;
    EXPECT_EQ(frame.added, -1) << text;
    EXPECT_FALSE(frame.is_own()) << text;
    EXPECT_FALSE(frame.match || frame.replaced || frame.drift || frame.manifold) << text;
    EXPECT_TRUE(frame.files.empty()) << text;
  }
  // A file that is named in another way is none that could be there.
  const FollowedFrame odd = followed_frame(7, R"({"files":[1,{"file":"a","bytes":"b"}]})");
  ASSERT_EQ(odd.files.size(), 2U);
  EXPECT_EQ(odd.files[1].print.bytes, -1);
}

TEST(FollowedFrame, IsTextAlsoWhereNamesAreNot) {
  FollowedFrame frame = own_frame();
  frame.skipped = {{3, "frame_\xff.ply"}};
  EXPECT_THAT(followed_text(frame), HasSubstr("\"why\":\"frame_\xEF\xBF\xBD.ply\""));
}

}  // namespace
}  // namespace mq
