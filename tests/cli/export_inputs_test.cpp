// export: what it reads is not written over, and what it says of itself can be done again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/moving_body.h"
#include "cli/moving_square.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

}  // namespace
}  // namespace mq::test
