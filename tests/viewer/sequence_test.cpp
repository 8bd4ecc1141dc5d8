// Sequences by frame, and other models in place of the one that is open.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mq/draw/camera.h"
#include "mq/draw/lifespans.h"
#include "mq/io/evolving_file.h"
#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// A square of two triangles; the second is another one from frame 12 on. Four frames, 10 to 13.
EvolvingMesh square_in_time() {
  EvolvingMesh evolving;
  for (const int second : {1, 2}) {
    EvolvingSegment segment;
    segment.vertex_ids = {0, 1, 2, 3};
    segment.triangles = {{0, 1, 2}, {0, 2, 3}};
    segment.triangle_ids = {0, second};
    evolving.segments.push_back(segment);
  }
  for (int f = 0; f < 4; ++f)
    evolving.frames.push_back({10 + f, f / 2, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
  return evolving;
}

/// Without an atlas the surface pane is as wide as both.
constexpr int whole_width = 600;

void expect_colour(const Image<float>& shown, const Mesh& mesh, const Vector3& place,
                   const Colour& wanted) {
  const Camera camera(mesh, parse_view("front"), whole_width, surface_height);
  const auto at = camera.project(place);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(shown(int(at.x), int(at.y), c), wanted[std::size_t(c)], 1.5 / 255);
}

TEST(Sequences, ShowLifespansInTheirColours) {
  const Folder folder;
  const EvolvingMesh evolving = square_in_time();
  write_evolving(folder / "square.evolving", evolving, store_step(1.5));
  const Result result = view(folder,
                             "view front\nlight off\nshow lifespans\n"
                             "frame 11\nscreenshot 11.png surface\n"
                             "frame 12\nscreenshot 12.png surface\n"
                             "frame 10\nplay 3\nscreenshot 13.png surface\n",
                             {"square.evolving"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Mesh mesh = evolving.mesh(0);
  const Vector3 lower(0.7, 0.3, 0), upper(0.3, 0.7, 0);
  const Image<float> early = picture(folder, "11.png"), late = picture(folder, "12.png");
  ASSERT_EQ(early.width(), whole_width);
  expect_colour(early, mesh, lower, lifespan_colour(0, 3, 4));
  expect_colour(early, mesh, upper, lifespan_colour(0, 1, 4));
  expect_colour(late, mesh, lower, lifespan_colour(0, 3, 4));
  expect_colour(late, mesh, upper, lifespan_colour(2, 3, 4));
  EXPECT_EQ(file_bytes(folder / "13.png"), file_bytes(folder / "12.png"));  // of the same segment
}

TEST(Sequences, RefuseFramesThatAreNotThere) {
  const Folder folder;
  write_evolving(folder / "square.evolving", square_in_time(), store_step(1.5));
  const Result result = view(folder, "frame 14\n", {"square.evolving"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error,
              HasSubstr("session.txt, line 1: there is no frame 14: there are 4, from 10 to 13"));
  EXPECT_EQ(view(folder, "", {"frame_%04d.ply"}).status, 2);  // there are none
}

TEST(Sequences, OfFilesShowEachFile) {
  const Folder folder;
  std::string other = coloured_ply;
  other.replace(other.find("200 200 200"), 11, "50 150 250");
  write_bytes(folder / "frame_0003.ply", coloured_ply);
  write_bytes(folder / "frame_0004.ply", other);
  const Result result = view(folder, "view front\nlight off\nframe 4\nscreenshot 4.png surface\n",
                             {"frame_%04d.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> shown = picture(folder, "4.png");
  EXPECT_NEAR(shown(shown.width() / 2, shown.height() / 2, 2), 250 / 255.0, 0.02);
}

/// Two frames of a textured sphere, 3 and 4, whose pictures are darker and brighter.
void write_frames(const Folder& folder) {
  write_sphere(folder);
  std::filesystem::remove(folder / "sphere.mtl");
  Texture texture = read_texture(folder / "sphere.png");
  for (const int frame : {3, 4}) {
    std::filesystem::copy_file(folder / "sphere.obj", folder / fmt::format("ball_{}.obj", frame));
    for (float& value : texture.pixels.values()) value *= 0.5F;
    write_texture(folder / fmt::format("skin_{:03d}.png", frame), texture);
  }
}

TEST(Sequences, ShowThePictureOfEachFrame) {
  const Folder folder;
  write_frames(folder);
  const Result result = view(folder,
                             "frame 4\nscreenshot shown.png surface\ntool denoise\n"
                             "set length 2tx\nwait\ncopy-command command.txt\n",
                             {"ball_%d.obj", "skin_%03d.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(view(folder, "screenshot alone.png surface\n", {"ball_4.obj", "skin_004.png"}).status,
            0);
  EXPECT_TRUE(file_bytes(folder / "shown.png") == file_bytes(folder / "alone.png"));
  EXPECT_EQ(file_bytes(folder / "command.txt"),
            "marquetry denoise --output=out.png --length=2tx ball_4.obj skin_004.png\n");
  std::filesystem::remove(folder / "skin_004.png");
  const Result lacking = view(folder, "", {"ball_%d.obj", "skin_%03d.png"});
  EXPECT_EQ(lacking.status, 2);
  EXPECT_THAT(lacking.error, HasSubstr("skin_004.png: is not there, the picture of frame 4"));
}

TEST(Sequences, OfAFolderAreItsFrames) {
  const Folder folder;
  std::filesystem::create_directory(folder / "balls");
  write_frames(folder);
  for (const char* name : {"ball_3.obj", "ball_4.obj"})
    std::filesystem::rename(folder / name, folder / "balls" / name);
  const Result result =
      view(folder, "frame 4\nscreenshot shown.png surface\n", {"balls", "skin_%03d.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(
      view(folder, "screenshot alone.png surface\n", {"balls/ball_4.obj", "skin_004.png"}).status,
      0);
  EXPECT_TRUE(file_bytes(folder / "shown.png") == file_bytes(folder / "alone.png"));
}

TEST(Sequences, OfAStoreShowThePictureOfEachFrame) {
  const Folder folder;
  EvolvingMesh evolving = square_in_time();
  for (EvolvingSegment& segment : evolving.segments) {
    segment.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    segment.corner_uvs = segment.triangles;
  }
  write_evolving(folder / "square.evolving", evolving, store_step(1.5));
  for (int f = 10; f < 14; ++f) {
    Image<float> grey(64, 64, 3);
    for (float& value : grey.values()) value = float(f) / 16;
    write_image(folder / fmt::format("grey_{}.png", f), grey);
  }
  const Result result = view(folder,
                             "view front\nlight off\nframe 12\nscreenshot 12.png surface\n"
                             "frame 11\nscreenshot 11.png surface\n",
                             {"square.evolving", "grey_%d.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  for (const int f : {11, 12}) {
    const Image<float> shown = picture(folder, fmt::format("{}.png", f));
    EXPECT_NEAR(shown(shown.width() / 2, shown.height() / 2, 1), f / 16.0, 1.5 / 255) << f;
  }
  EXPECT_EQ(view(folder, "", {"square.evolving", "grey_10.png", "grey_11.png"}).status, 2);
}

TEST(Opening, PutsAnotherModelInPlaceAndKeepsTheOldOneWhereItCannot) {
  const Folder folder;
  write_strip(folder);
  write_sphere(folder);
  const Result result = view(folder,
                             "open sphere.obj\nhover surface 180 200\nscreenshot opened.png atlas\n"
                             "open nothing.obj\n",
                             {"strip.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("session.txt, line 4: cannot read nothing.obj"));
  ASSERT_EQ(
      view(folder, "hover surface 180 200\nscreenshot first.png atlas\n", {"sphere.obj"}).status,
      0);
  EXPECT_EQ(file_bytes(folder / "opened.png"), file_bytes(folder / "first.png"));
}

TEST(Opening, KeepsWhatIsShownUntilAllOfTheOtherIsThere) {
  const Folder folder;
  write_strip(folder);
  write_sphere(folder,
               "2048");  // which takes many times as long as the two pictures of a screenshot
  const Result result = view(folder,
                             "screenshot alone.png surface\n"
                             "drop sphere.obj\nscreenshot while_loading.png surface\n"
                             "screenshot panel.png\n"
                             "wait\nhover surface 180 200\n"
                             "drop strip.obj\nstop\nwait\nhover surface 180 200\n",
                             {"strip.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(file_bytes(folder / "while_loading.png") == file_bytes(folder / "alone.png"));
  const auto picks = result.json()["result"]["picks"];
  EXPECT_GT(picks[0]["pick"]["face"].get<int>(), 4);  // the strip has not as many
  EXPECT_EQ(picks[1]["pick"]["face"], picks[0]["pick"]["face"]);
}

TEST(Opening, AsksBeforePaintingIsLost) {
  const Folder folder;
  write_strip(folder);
  write_sphere(folder);
  const std::string paint = "tool filter\nset length 2tx\nsize 20%\nstroke 0,0,1\n";
  const Result result = view(folder,
                             paint +
                                 "drop strip.obj\nwait\nscreenshot asked.png\nanswer no\n"
                                 "hover surface 180 200\nsave-texture kept.png\n"
                                 "stroke 1,0,0\ndrop strip.obj\nanswer yes\nhover surface 180 200\n"
                                 "open sphere.obj\n" +
                                 paint + "open strip.obj\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto picks = result.json()["result"]["picks"];
  EXPECT_GT(picks[0]["pick"]["face"].get<int>(), 4);
  EXPECT_LE(picks[1]["pick"]["face"].get<int>(), 4);
  EXPECT_THAT(result.error,
              HasSubstr("what was painted with the filter was not saved, and is gone"));
  ASSERT_EQ(view(folder, paint + "save-texture painted.png\n", {"sphere.obj"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "kept.png") == file_bytes(folder / "painted.png"));

  // Saved as it is, nothing is lost, and nothing asked.
  const Result saved =
      view(folder, paint + "save-mask mask.png\ndrop strip.obj\nanswer yes\n", {"sphere.obj"});
  EXPECT_EQ(saved.status, 2);
  EXPECT_THAT(saved.error, HasSubstr("line 7: there is nothing to answer"));

  // A script has the last word.
  for (const char* last : {"drop strip.obj\n", "close\n"}) {
    const Result open = view(folder, paint + last, {"sphere.obj"});
    EXPECT_EQ(open.status, 2);
    EXPECT_THAT(open.error, HasSubstr("line 5: the script ends while it is asked 'You have not saved "));
  }
}

TEST(Closing, WaitsForWhatIsBeingSaved) {
  const Folder folder;
  write_strip(folder);
  write_sphere(folder);
  const std::string lic = "tool lic\nset length 20tx\n";
  ASSERT_EQ(view(folder, lic + "save-texture plain.png\n", {"sphere.obj"}).status, 0);
  const Result closed =
      view(folder, lic + "save-texture behind.png behind\nclose\nsave-texture never.png\n",
           {"sphere.obj"});
  ASSERT_EQ(closed.status, 0) << closed.error;
  EXPECT_TRUE(file_bytes(folder / "behind.png") == file_bytes(folder / "plain.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "never.png"));
  // So does another model, and whoever does not want to wait is told what that costs.
  const Result opened = view(folder,
                             lic +
                                 "save-texture a.png behind\ndrop strip.obj\nwait\n"
                                 "frames 1\nwait\nhover surface 180 200\n",
                             {"sphere.obj"});
  ASSERT_EQ(opened.status, 0) << opened.error;
  EXPECT_TRUE(file_bytes(folder / "a.png") == file_bytes(folder / "plain.png"));
  const Result given_up =
      view(folder, lic + "save-texture b.png behind\nstop\nclose\nanswer yes\n", {"sphere.obj"});
  ASSERT_EQ(given_up.status, 0) << given_up.error;
  EXPECT_THAT(given_up.error, HasSubstr("not saved: b.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.png"));
}

TEST(Closing, ReportsWhatIsOpenThen) {
  const Folder folder;
  write_strip(folder);
  write_sphere(folder);
  const Result result = view(folder, "open strip.obj\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.json()["input"]["files"][0].get<std::string>(), HasSubstr("strip.obj"));
  const Result lacking = view(folder, "show lifespans\n", {"sphere.obj"});
  EXPECT_EQ(lacking.status, 2);
  EXPECT_THAT(lacking.error, HasSubstr("line 1: the model has no lifespans"));
}

TEST(Sequences, AreOpenedInPlaceOfAModelAndPlayedFrameByFrame) {
  const Folder folder;
  write_strip(folder);
  std::string other = coloured_ply;
  other.replace(other.find("200 200 200"), 11, "50 150 250");
  for (const char* name : {"frame_0003.ply", "frame_0005.ply"})
    write_bytes(folder / name, coloured_ply);
  write_bytes(folder / "frame_0004.ply", other);
  const Result result =
      view(folder,
           "open frame_%04d.ply\nshow vertex-colours\nview front\nlight off\n"
           "play 1\nscreenshot 4.png surface\nplay 3\nscreenshot 4_again.png surface\n"
           "play 2\nscreenshot 3.png surface\n",
           {"strip.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto blue = [&](const std::string& name) {
    const Image<float> shown = picture(folder, name);
    return shown(shown.width() / 2, shown.height() / 2, 2);
  };
  EXPECT_NEAR(blue("4.png"), 250 / 255.0, 0.02);
  EXPECT_TRUE(file_bytes(folder / "4_again.png") == file_bytes(folder / "4.png"));
  EXPECT_NEAR(blue("3.png"), 200 / 255.0, 0.02);
}

}  // namespace
}  // namespace mq::test
