// export: what it reads is not written over, and what it says of itself can be done again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/moving_body.h"
#include "cli/moving_square.h"
#include "mq/io/animation_read.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Json = nlohmann::json;

/// Refused with these words, and the file is what it was.
void expect_kept(const Folder& folder, const std::string& file, std::vector<std::string> words) {
  SCOPED_TRACE(testing::PrintToString(words));
  const std::string before = file_bytes(folder / file);
  words.insert(words.begin(), "export");
  const Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 2) << result.output;
  EXPECT_THAT(result.error, AllOf(HasSubstr(file), HasSubstr("which is read"), HasSubstr("--overwrite")));
  EXPECT_EQ(file_bytes(folder / file), before);
}

TEST(ExportInputs, CapturedFramesAreNotReplaced) {
  const Folder folder;
  make_square(folder);
  std::filesystem::create_directory(folder / "ply");
  std::filesystem::create_directory(folder / "obj");
  for (const std::string format : {"ply", "obj"})
    ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", format + "/f_%02d." + format}).status, 0);
  expect_kept(folder, "ply/f_10.ply", {"square.usda", "-o", "ply/f_%02d.ply", "--from", "ply/", "--size", "16"});
  // What they name: pictures, and material libraries.
  for (const std::string format : {"ply", "obj"}) {
    const std::string frames = format + "/f_%02d." + format;
    expect_kept(folder, format + "/f_10.png",
                {"square.usda", "-o", format + "/f_%02d.png", "--from", frames, "--size", "16"});
  }
  expect_kept(folder, "ply/f_10.png", {"square.usda", "-o", "ply/f_%02d.obj", "--from", "ply/", "--size", "16"});
  expect_kept(folder, "obj/f_12.mtl", {"square.usda", "-o", "new_%02d.ply", "--from", "obj/", "--size", "16",
                                       "--frames", "12", "--report", "obj/f_12.mtl"});
  // Pictures that are given instead of theirs.
  std::filesystem::copy_file(folder / "ply/f_10.png", folder / "given_10.png");
  expect_kept(folder, "given_10.png", {"square.usda", "-o", "given_%02d.png", "--from", "ply/", "--size", "16",
                                       "--frames", "10", "--texture", "given_%02d.png"});
  EXPECT_EQ(marquetry(folder, {"export", "square.usda", "-o", "ply/f_%02d.ply", "--from", "ply/", "--size", "16",
                               "--overwrite"})
                .status,
            0);
}

TEST(ExportInputs, PicturesOfTheFileThatMovesAreNotReplaced) {
  const Folder folder;
  make_square(folder);
  ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", "b.usda"}).status, 0);
  std::filesystem::rename(folder / "b.usda", folder / "q.usda");
  expect_kept(folder, "b_0.png", {"q.usda", "-o", "b.usda"});
  std::string text = file_bytes(folder / "square.usda");
  text.replace(text.find("colours.png"), 11, "f_12.png");
  write_bytes(folder / "f.usda", text);
  std::filesystem::copy_file(folder / "colours.png", folder / "f_12.png");
  expect_kept(folder, "f_12.png", {"f.usda", "-o", "f_%d.obj"});
}

TEST(ExportInputs, LibrariesAreAmongTheOutputs) {
  const Folder folder;
  make_square(folder);
  const std::vector<std::string> words = {"export", "square.usda", "-o", "f_%d.obj", "--frames", "10"};
  const auto with = [&](const std::string& word) {
    std::vector<std::string> all = words;
    all.push_back(word);
    return marquetry(folder, all);
  };
  EXPECT_THAT(with("--dry-run").error, HasSubstr("would write f_10.mtl"));
  EXPECT_EQ(with("--json").json()["result"]["outputs"], Json({"f_10.obj", "f_10.png", "f_10.mtl"}));
  for (const char* name : {"f_10.obj", "f_10.png"}) std::filesystem::remove(folder / name);
  const Result refused = with("--no-clobber");
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("f_10.mtl: exists already"));
  EXPECT_FALSE(std::filesystem::exists(folder / "f_10.obj"));
  // Of captured frames as well.
  ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", "c_%d.ply"}).status, 0);
  const Result captured = marquetry(folder, {"export", "square.usda", "-o", "d_%d.obj", "--from", "c_%d.ply",
                                             "--frames", "10", "--size", "16", "--json"});
  EXPECT_EQ(captured.json()["result"]["outputs"], Json({"d_10.obj", "d_10.png", "d_10.mtl"})) << captured.error;
}

/// Pictures whose names nobody gave are replaced where the model that showed them is, frame by frame.
TEST(ExportInputs, FramesAreReplacedEachByItself) {
  const Folder folder;
  make_square(folder);
  const auto with = [&](const std::string& frames) {
    return marquetry(folder, {"export", "square.usda", "-o", "f_%d.obj", "--frames", frames});
  };
  for (const char* frames : {"10", "10", "10-12x2"}) EXPECT_EQ(with(frames).status, 0) << with(frames).error;
  std::filesystem::remove(folder / "f_12.obj");
  const Result refused = with("10-12x2");
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("f_12.png: exists already, and the new f_12.obj would replace it"));
}

TEST(ExportInputs, CapturedFramesWithoutTrianglesAreNamed) {
  const Folder folder;
  make_square(folder);
  ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", "c_%d.ply"}).status, 0);
  write_bytes(folder / "c_12.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
              "end_header\n0 0 0\n");
  const Result refused = marquetry(folder, {"export", "square.usda", "-o", "d_%d.png", "--from", "c_%d.ply", "--size", "16"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, AllOf(HasSubstr("c_12.ply: frame 12 has no triangles"), HasSubstr("--frames")));
}

/// A report has the options that were in force, and with them the same is made again.
TEST(ExportInputs, ReportsCanBeRepeated) {
  const Folder folder;
  make_square(folder);
  const std::vector<std::string> words = {"export", "square.usda", "-o", "walk.usda", "--report", "r.json"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const std::string made = file_bytes(folder / "walk.usda");
  EXPECT_FALSE(Json::parse(file_bytes(folder / "r.json"))["options"].contains("rate"));
  std::filesystem::remove(folder / "walk.usda");
  const Result again = marquetry(folder, {"export", "--config", "r.json"});
  EXPECT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "walk.usda"), made);
  EXPECT_NEAR(open_animation(folder / "walk.usda").frames_per_second, 12, 1e-5);
  // What is asked for and does not fit is refused as before.
  EXPECT_EQ(marquetry(folder, {"export", "--config", "r.json", "--samples", "3"}).status, 2);
}

TEST(ExportInputs, WhatIsWrongOrMissingIsNamed) {
  const Folder folder;
  make_square(folder);
  const Result gaps = marquetry(folder, {"export", "square.usda", "-o", "f_%d.ply", "--frames", "10-14"});
  EXPECT_EQ(gaps.status, 2);
  EXPECT_THAT(gaps.error, HasSubstr("has no frame 11; it has 10, 12, 14"));
  ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", "a.glb"}).status, 0);
  std::string bytes = file_bytes(folder / "a.glb");
  bytes[bytes.find("\x89PNG") + 20] ^= 0x55;
  write_bytes(folder / "a.glb", bytes);
  const Result damaged = marquetry(folder, {"export", "a.glb"});
  EXPECT_EQ(damaged.status, 2);
  EXPECT_THAT(damaged.error, HasSubstr("a.glb, the embedded picture"));
}

}  // namespace
}  // namespace mq::test
