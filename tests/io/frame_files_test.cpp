#include "mq/io/frame_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "mq/base/error.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

/// A folder with empty files of these names, gone at the end.
class Folder {
 public:
  explicit Folder(const std::vector<std::string>& names) {
    fs::create_directories(path_);
    for (const std::string& name : names) std::ofstream(path_ / name).put('\n');
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_ =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

std::vector<int> numbers(const std::vector<FrameFile>& frames) {
  std::vector<int> all;
  for (const FrameFile& frame : frames) all.push_back(frame.number);
  return all;
}

std::string refusal(const std::string& name, const std::vector<int>& wanted = {}) {
  try {
    find_frames(name, wanted);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(FrameFiles, AreSortedByNumberNotByName) {
  const Folder folder({"m_9.ply", "m_10.ply", "m_100.ply", "m_2.ply", "notes.txt", ".m_1.ply"});
  EXPECT_THAT(numbers(find_frames(folder.path())), ElementsAre(2, 9, 10, 100));
  EXPECT_THAT(numbers(find_frames(folder / "m_%d.ply")), ElementsAre(2, 9, 10, 100));
}

TEST(FrameFiles, MatchAPlaceOfFixedWidthExactly) {
  const Folder folder({"a_0001.obj", "a_0012.obj", "a_13.obj", "a_0014.ply", "a_0015.obj.bak"});
  const auto frames = find_frames(folder / "a_%04d.obj");
  EXPECT_THAT(numbers(frames), ElementsAre(1, 12));
  EXPECT_EQ(frames[1].path.string(), folder / "a_0012.obj");
}

TEST(FrameFiles, TakeWhatFollowsTheNumberAsPartOfTheName) {
  const Folder folder({"7_body.glb", "8_body.glb"});
  EXPECT_THAT(numbers(find_frames(folder.path())), ElementsAre(7, 8));
}

TEST(FrameFiles, AreThoseAskedForAndAllOfThem) {
  const Folder folder({"f1.ply", "f2.ply", "f3.ply", "f5.ply"});
  EXPECT_THAT(numbers(find_frames(folder.path(), parse_frames("1-5x2"))), ElementsAre(1, 3, 5));
  EXPECT_THAT(
      refusal(folder.path(), parse_frames("1-6")),
      HasSubstr("2 of 6 frames are missing, the first is frame 4; there are 4, from 1 to 5"));
}

TEST(FrameFiles, OfSeveralSequencesInOneFolderAreRefused) {
  const Folder formats({"f1.ply", "f2.obj"});
  EXPECT_THAT(refusal(formats.path()), HasSubstr("f1.ply and f2.obj are not of one sequence"));
  const Folder names({"a1.ply", "b2.ply"});
  EXPECT_THAT(refusal(names.path()), HasSubstr("not of one sequence"));
}

TEST(FrameFiles, WithOneNumberAreRefused) {
  const Folder folder({"f1.ply", "f01.ply"});
  EXPECT_THAT(refusal(folder.path()), HasSubstr("are both frame 1"));
  EXPECT_THAT(numbers(find_frames(folder / "f%02d.ply")), ElementsAre(1));
}

TEST(FrameFiles, ThatAreNotThereAreRefused) {
  const Folder folder({"notes.txt", "model.ply"});
  EXPECT_THAT(refusal(folder.path()), HasSubstr("no frames in this folder"));
  EXPECT_THAT(refusal(folder / "f%d.ply"), HasSubstr("no file is called so"));
  EXPECT_THAT(refusal(folder / "nowhere"), HasSubstr("no such file or folder"));
  EXPECT_THAT(refusal(folder / "nowhere/f%d.ply"), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(folder / "model.ply"), HasSubstr("found one file, wanted a sequence"));
  EXPECT_THAT(refusal(folder / "f%d/model.ply"), HasSubstr("not of the folder"));
}

TEST(FrameFiles, HaveNumbersOfTenDigitsAndNoLargerOnes) {
  const Folder folder({"f1700000000.ply", "f1700000001.ply", "99999999999999.ply.txt"});
  EXPECT_THAT(numbers(find_frames(folder.path())), ElementsAre(1700000000, 1700000001));
  EXPECT_THAT(numbers(find_frames(folder / "f%d.ply", parse_frames("1700000001-1700000001"))),
              ElementsAre(1700000001));
  const Folder larger({"f7.ply", "f1700000000123.ply", "1700000000123.ply"});
  for (const std::string& name : {larger.path(), larger / "f%d.ply"}) {
    EXPECT_THAT(refusal(name), HasSubstr("1700000000123.ply: its number 1700000000123 is larger"));
    EXPECT_THAT(refusal(name), HasSubstr("2147483647"));
  }
  EXPECT_THAT(refusal(larger / "g%d.ply"), HasSubstr("no file is called so"));
  const Folder scene({"walk.usdz", "walk.ply"});
  EXPECT_THAT(refusal(scene / "walk.usdz"), HasSubstr("write a file a frame"));
  EXPECT_THAT(refusal(scene / "walk.ply"), HasSubstr("found one file, wanted a sequence"));
}

TEST(FrameFiles, ThatAreMissingMayBeLeftOut) {
  const Folder folder({"f1.ply", "f2.ply", "f4.ply"});
  EXPECT_THAT(numbers(find_frames(folder.path(), parse_frames("1-5"), MissingFrames::left_out)),
              ElementsAre(1, 2, 4));
  EXPECT_THROW(find_frames(folder.path(), {3}, MissingFrames::left_out), IoError);
}

TEST(Frames, HaveOnePlaceForTheirNumber) {
  EXPECT_TRUE(has_frame_place("a/f_%04d.ply"));
  EXPECT_FALSE(has_frame_place("a/f_4d.ply"));
  EXPECT_THROW(has_frame_place("one_%d_%d.ply"), InvalidInput);
}

TEST(Frames, AreANumberARangeOrEveryNth) {
  EXPECT_THAT(parse_frames("5"), ElementsAre(5));
  EXPECT_THAT(parse_frames("3-9x3"), ElementsAre(3, 6, 9));
  EXPECT_THAT(parse_frames("2147483646-2147483647"), ElementsAre(2147483646, 2147483647));
  for (const char* text :
       {"", "5-1", "-3", "1-5x0", "a", "1-", "0-9999999", "2147483648", "0-99999999999"})
    EXPECT_TRUE(parse_frames(text).empty()) << text;
}

}  // namespace
}  // namespace mq
