// Files in folders that may not be searched: what is said is that, whatever the file is for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "cli/program.h"

namespace mq::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Words = std::vector<std::string>;

/// The strip, and a folder beside it that nobody but root may search. Everybody may write beside it.
class ClosedFolder : public ::testing::Test {
 protected:
  ClosedFolder() {
    write_strip(folder);
    fs::create_directory(folder / "closed");
    fs::copy_file(folder / "strip.png", folder / "closed/strip.png");
    fs::permissions(folder.path(), fs::perms::all);
    fs::permissions(folder / "closed", fs::perms::none);
  }
  ~ClosedFolder() override { fs::permissions(folder / "closed", fs::perms::owner_all); }

  Result run(const Words& words) const { return marquetry(folder, words, {.user = RunOptions::User::ordinary}); }

  /// Whether an ordinary user can start the program where it lies.
  bool is_kept_out() const { return run({"--version"}).status == 0; }

  const Folder folder;
};

TEST_F(ClosedFolder, IsSaidToBeClosedForOutputs) {
  if (!is_kept_out()) GTEST_SKIP() << "an ordinary user cannot start the program where it was built";
  const Words to_be_written[] = {
      {"filter", "strip.obj", "--beta", "2", "-o", "closed/x.png"},
      {"filter", "strip.obj", "--beta", "2", "-o", "closed/x.obj"},
      {"filter", "strip.obj", "--beta", "2", "-o", "closed/"},
      {"filter", "strip.obj", "--beta", "2", "-o", "closed/new/deep/x.png"},
      {"filter", "strip.obj", "--beta", "2", "-o", "x.png", "--report", "closed/r.json"},
      {"geodesic", "strip.obj", "--from", "0,0,0", "-o", "closed/x.png"},
      {"sample", "bust", "-o", "closed/"},
      {"sample", "bending", "--frames", "1-3", "-o", "closed/"},
      {"flow", "strip.png", "strip.png", "-o", "closed/"},
      {"flow", "strip.png", "strip.png", "-o", "closed/f.x"},
      {"spectrum", "strip.obj", "-o", "closed/s/"},
      {"render", "strip.obj", "-o", "closed/x.png"},
      {"shock", "strip.obj", "-o", "closed/x.png", "--write-potential", "closed/p.exr"},
      {"filter", "strip.obj", "--beta", "2", "-o", "x.png", "--memory", "300MB", "--scratch", "closed"}};
  for (const Words& words : to_be_written) {
    const Result result = run(words);
    EXPECT_EQ(result.status, 2) << ::testing::PrintToString(words);
    EXPECT_THAT(result.error, AllOf(HasSubstr("closed"), HasSubstr("Permission denied; choose"),
                                    Not(HasSubstr("internal error")), Not(HasSubstr("two outputs"))))
        << ::testing::PrintToString(words);
  }
  EXPECT_FALSE(fs::exists(folder / "x.png"));
}

TEST_F(ClosedFolder, IsSaidToBeClosedForInputs) {
  if (!is_kept_out()) GTEST_SKIP() << "an ordinary user cannot start the program where it was built";
  const Words to_be_read[] = {{"filter", "strip.obj", "closed/strip.png", "--beta", "2", "-o", "x.png"},
                              {"filter", "closed/strip.png", "--beta", "2", "-o", "x.png"},
                              {"filter", "strip.obj", "--beta", "2", "--mask", "closed/strip.png", "-o", "x.png"},
                              {"filter", "closed/strip.obj", "--beta", "2", "-o", "x.png"},
                              {"filter", "closed/s%04d.png", "--frames", "1-2", "--beta", "2", "-o", "x%04d.png"},
                              {"geodesic", "strip.obj", "--from-mask", "closed/strip.png", "-o", "x.png"},
                              {"cameras", "closed/c.json"},
                              {"cameras", "closed/"},
                              {"texture", "strip.obj", "--cameras", "closed/c.json", "-o", "x.png"},
                              {"export", "closed/e.evolving", "-o", "x.glb"},
                              {"track", "closed/f_%04d.ply", "-o", "x.evolving"}};
  for (const Words& words : to_be_read) {
    const Result result = run(words);
    EXPECT_EQ(result.status, 2) << ::testing::PrintToString(words);
    EXPECT_THAT(result.error, AllOf(HasSubstr("closed"), HasSubstr("Permission denied"), HasSubstr("choose"),
                                    Not(HasSubstr("internal error")), Not(HasSubstr("no such"))))
        << ::testing::PrintToString(words);
  }
}

TEST(Outputs, MakeTheFoldersAroundAFileAsThoseOfAFolder) {
  const Folder folder;
  write_strip(folder);
  for (const std::string output : {"new/deep/folder/d.png", "other/deep/folder/"}) {
    const Result result = marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", output});
    EXPECT_EQ(result.status, 0) << result.error;
  }
  EXPECT_TRUE(fs::exists(folder / "new/deep/folder/d.png"));
  EXPECT_TRUE(fs::exists(folder / "other/deep/folder/strip.png"));
  EXPECT_EQ(marquetry(folder, {"filter", "strip.obj", "--beta", "2", "--mask", "none.png", "-o", "third/deep/d.png"}).status,
            2);
  EXPECT_FALSE(fs::exists(folder / "third")) << "left empty";
}

TEST(StandardOutput, IsNotSaidToBeWrittenWhereItCannotBe) {
  const Folder folder;
  write_strip(folder);
  const Words words = {"filter", "strip.obj", "--beta", "2", "-o", "png:-"};
  const Result full = marquetry(folder, words, {.standard_output = "/dev/full"});
  EXPECT_EQ(full.status, 2);
  EXPECT_THAT(full.error, AllOf(HasSubstr("cannot be written to"), Not(HasSubstr("wrote"))));
  EXPECT_THAT(marquetry(folder, words).error, HasSubstr("wrote standard output"));
}

}  // namespace
}  // namespace mq::test
