#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "cli/models.h"
#include "evolving/evolving_models.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"

namespace mq::test {
namespace {

TEST(Cancelling, LeavesNothingBehind) {
  const Folder folder;
  write_strip(folder, 2000, 1500);
  const auto before = folder.names();
  // It speaks of its progress after a second, long before it is done.
  const Result result = marquetry(folder,
                                  {"filter", "strip.obj", "-o", "out/", "--beta", "2", "--solver",
                                   "reference", "--alpha", "1", "--threads", "1"},
                                  {.interrupt_at = {"%"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("cancelled"));
  EXPECT_EQ(folder.names(), before);
}

TEST(Cancelling, DoesNotWaitForAnEncoderThatReadsNothing) {
  const Folder folder;
  for (const char* name : {"a.png", "b.png"}) write_image(folder / name, busy_picture(511, 513));
  // The frame that it is given first is never taken, and it would end in a minute.
  std::filesystem::create_directory(folder / "bin");
  write_bytes(folder / "bin/ffmpeg", "#!/bin/sh\nexec sleep 60\n");
  std::filesystem::permissions(folder / "bin/ffmpeg", std::filesystem::perms::owner_all);
  const auto before = folder.names();
  const Result result =
      marquetry(folder, {"interpolate", "a.png", "b.png", "-o", "out.mp4", "--frames", "0-2"},
                {.environment = {{"PATH", (folder / "bin").string() + ":" + std::getenv("PATH")}},
                 .interrupt_at = {"are cut to"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("cancelled, nothing half-written is left"));
  EXPECT_EQ(folder.names(), before);
}

TEST(Cancelling, DoesNotWaitForFactorisations) {
  const Folder folder;
  write_strip(folder, 2000, 1500);
  const auto before = folder.names();
  // This one takes longer than the test.
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "-o", "out/", "--beta", "0", "--solver", "direct"},
                {.interrupt_at = {"analysis"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("cancelled, nothing half-written is left"));
  EXPECT_EQ(folder.names(), before);
}

TEST(Cancelling, EndsAtOnceWhenAskedAgain) {
  const Folder folder;
  const Result result = marquetry(
      folder, {"stubborn", "-o", "out.png"},
      {.interrupt_at = {"at work", "press Ctrl-C again to stop at once"}, .program = "stubborn"});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("stopped at once, nothing half-written is left"));
  EXPECT_TRUE(folder.names().empty());
}

TEST(Cancelling, SaysHowManyFramesAreThere) {
  const Folder folder;
  for (const char* name : {"a.png", "b.png"}) write_image(folder / name, busy_picture(200, 200));
  const Result result = marquetry(
      folder,
      {"interpolate", "a.png", "b.png", "-o", "f_%05d.png", "--frames", "0-9999", "--threads", "1"},
      {.interrupt_at = {"frame"}});
  EXPECT_EQ(result.status, 130) << result.error;
  const auto names = folder.names();
  const auto frames =
      std::ranges::count_if(names, [](const std::string& name) { return name.starts_with("f_"); });
  ASSERT_GT(frames, 0) << result.error;
  EXPECT_THAT(result.error,
              testing::HasSubstr("nothing half-written is left; " + std::to_string(frames) +
                                 (frames == 1 ? " file is" : " files are") + " complete"));
  EXPECT_THAT(result.error, testing::HasSubstr("the last of them f_"));
}

/// A run that is stopped once it speaks of its progress, and leaves nothing behind.
void expect_stopped(const Folder& folder, std::vector<std::string> words) {
  const auto before = folder.names();
  words.insert(words.end(), {"--threads", "1"});
  const Result result = marquetry(folder, words, {.interrupt_at = {"%"}});
  EXPECT_EQ(result.status, 130) << words[0] << ": " << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("cancelled"));
  EXPECT_EQ(folder.names(), before) << words[0];
}

TEST(Cancelling, StopsUnwrappingOfEvolvingMeshes) {
  const Folder folder;
  write_evolving(folder / "sheet.evolving", patched_sheet(60, 12, 5), store_step(60));
  expect_stopped(folder, {"unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size", "2048",
                          "--trials", "100000"});
}

TEST(Cancelling, StopsTextureVideosAndTheirFilters) {
  const Folder folder;
  const EvolvingMesh sheet = patched_sheet(10, 8, 5);
  write_evolving(folder / "sheet.evolving", sheet, store_step(10));
  std::filesystem::create_directory(folder / "captured");
  for (int f = 0; f < int(sheet.frames.size()); ++f) {
    Model captured;
    captured.mesh = sheet.mesh(f);
    captured.colors.channels = 3;
    captured.colors.values.assign(3 * captured.mesh.positions.size(), 0.5F);
    write_model(folder / "captured" / frame_name("f_%02d.ply", sheet.frames[std::size_t(f)].number),
                captured);
  }
  ASSERT_EQ(marquetry(folder, {"unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size", "64",
                               "--trials", "2"})
                .status,
            0);
  expect_stopped(folder, {"export", "atlas.evolving", "-o", "film.mkv", "--from",
                          "captured/f_%02d.ply", "--size", "1024", "--samples", "4"});
  for (int f = 0; f < 24; ++f)
    write_image(folder / ("t_" + std::to_string(f) + ".png"), busy_picture(512, 512));
  for (const char* method : {"mean", "poisson"})
    expect_stopped(folder,
                   {"relight", "atlas.evolving", "t_%d.png", "-o", "lit.mkv", "--method", method});
}

/// What was followed until then is a store that --resume goes on with.
TEST(Cancelling, KeepsWhatEvolveHasFollowed) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "balls/", "--triangles", "4000",
                               "--frames", "0-7"})
                .status,
            0);
  const std::vector<std::string> words = {"evolve", "balls",    "-o", "balls.evolving", "--size",
                                          "128",    "--trials", "2",  "--resume"};
  std::vector<std::string> one_thread = words;
  one_thread.insert(one_thread.end(), {"--threads", "1"});
  const Result result = marquetry(folder, one_thread, {.interrupt_at = {"%"}});
  EXPECT_EQ(result.status, 130) << result.error;
  if (std::filesystem::exists(folder / "balls.evolving")) {
    EXPECT_THAT(result.error,
                testing::HasSubstr("nothing half-written is left; balls.evolving has "));
    EXPECT_THAT(result.error, testing::HasSubstr("of 8 frames, and --resume goes on from there"));
    EXPECT_THAT(result.error, testing::Not(testing::HasSubstr("complete")));
    EXPECT_EQ(EvolvingReader(folder / "balls.evolving").broken(), "");
  }
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const EvolvingMesh evolving = EvolvingReader(folder / "balls.evolving").read();
  EXPECT_EQ(evolving.frames.size(), 8U);
  for (const EvolvingSegment& segment : evolving.segments) EXPECT_FALSE(segment.uvs.empty());
}

}  // namespace
}  // namespace mq::test
