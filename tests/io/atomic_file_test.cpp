#include "mq/io/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "mq/base/error.h"

namespace mq {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// An empty folder of this test's own, removed with what is in it.
class AtomicFileTest : public ::testing::Test {
 protected:
  AtomicFileTest() { fs::create_directories(folder); }
  ~AtomicFileTest() override { fs::remove_all(folder); }

  static void put(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  static std::string get(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  int files() const {
    return int(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  static std::string error_of(const auto& action) {
    try {
      action();
    } catch (const IoError& error) {
      return error.what();
    }
    return "";
  }

  const fs::path folder =
      fs::temp_directory_path() /
      ("mq_atomic_" + std::to_string(::getpid()) +
       ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(AtomicFileTest, AppearsOnlyWhenCommitted) {
  const fs::path path = folder / "a b.png";
  {
    AtomicFile file(path);
    EXPECT_EQ(file.temporary().parent_path(), folder);
    EXPECT_EQ(file.temporary().extension(), ".png");
    put(file.temporary(), "new");
    EXPECT_FALSE(fs::exists(path));
    file.commit();
    EXPECT_EQ(get(path), "new");
  }
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, LeavesTheOldFileWhenNotCommitted) {
  put(folder / "x", "old");
  {
    AtomicFile file(folder / "x");
    put(file.temporary(), "half");
  }
  EXPECT_EQ(get(folder / "x"), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, KeepsThePermissionsOfTheFileItReplaces) {
  put(folder / "x", "old");
  ::chmod((folder / "x").c_str(), 0640);
  write_file(folder / "x", std::as_bytes(std::span("new", 3)));
  struct stat now;
  ASSERT_EQ(::stat((folder / "x").c_str(), &now), 0);
  EXPECT_EQ(now.st_mode & 0777, 0640u);
  EXPECT_EQ(get(folder / "x"), "new");
}

TEST_F(AtomicFileTest, WritesThroughALink) {
  put(folder / "x", "old");
  fs::create_symlink("x", folder / "link");
  write_file(folder / "link", std::as_bytes(std::span("new", 3)));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(get(folder / "x"), "new");
}

TEST_F(AtomicFileTest, MakesOneFolderAndLeavesItNotEmpty) {
  { AtomicFile given_up(folder / "new" / "x"); }
  EXPECT_FALSE(fs::exists(folder / "new"));
  write_file(folder / "new" / "x", {});
  EXPECT_TRUE(fs::exists(folder / "new" / "x"));
  fs::remove_all(folder / "new");
}

TEST_F(AtomicFileTest, RefusesADirectoryAndMissingFolders) {
  EXPECT_THAT(error_of([&] { AtomicFile file(folder); }), HasSubstr("is a directory"));
  EXPECT_THAT(error_of([&] { AtomicFile file(folder / "no" / "ne" / "x"); }),
              HasSubstr("make the folder around its folder first"));
  EXPECT_EQ(files(), 0);
}

TEST_F(AtomicFileTest, MakesAFolderOnDemandForTheFirstFile) {
  const fs::path out = folder / "out" / "pictures";
  make_on_demand(out.string() + "/");
  EXPECT_EQ(files(), 0);
  {
    AtomicFile given_up(out / "x");
    EXPECT_TRUE(fs::exists(given_up.temporary()));
  }
  EXPECT_EQ(files(), 0);
  {
    AtomicFile unfinished(out / "x");
    { const auto held = remove_unfinished_files(); }
    EXPECT_EQ(files(), 0);
  }
  const int before = written_files().count;
  write_file(out / "x", {});
  EXPECT_TRUE(fs::exists(out / "x"));
  EXPECT_EQ(written_files().count, before + 1);
  EXPECT_EQ(written_files().last, out / "x");
  { AtomicFile second(out / "y"); }
  EXPECT_TRUE(fs::exists(out / "x"));
  make_no_more(out);
  fs::remove_all(folder / "out");
  EXPECT_THAT(error_of([&] { AtomicFile file(out / "x"); }), HasSubstr("make the folder around its folder first"));
}

TEST_F(AtomicFileTest, SaysWhyAFolderCannotBeMade) {
  put(folder / "file", "");
  make_on_demand(folder / "file" / "in");
  EXPECT_THAT(error_of([&] { AtomicFile file(folder / "file" / "in" / "x"); }),
              HasSubstr("the folder cannot be made: Not a directory"));
  make_no_more(folder / "file" / "in");
}

TEST_F(AtomicFileTest, FitsALongNameIntoTheFileSystem) {
  const fs::path path = folder / (std::string(250, 'n') + ".obj");
  write_file(path, {});
  EXPECT_TRUE(fs::exists(path));
}

TEST_F(AtomicFileTest, RefusesWhatIsNotAFile) {
  fs::create_symlink("/dev/null", folder / "null");
  EXPECT_THAT(error_of([&] { write_file(folder / "null", std::as_bytes(std::span("x", 1))); }),
              HasSubstr("not an ordinary file"));
}

TEST_F(AtomicFileTest, SaysThatNoMoreCouldBeWrittenAndLeavesTheOldFile) {
  put(folder / "x", "old");
  // A limit on the size of files stands for a full disk.
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  ::getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1000;
  ::setrlimit(RLIMIT_FSIZE, &small);
  const std::vector<std::byte> bytes(5000);
  const std::string error = error_of([&] { write_file(folder / "x", bytes); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(error, HasSubstr("x: File too large; make room"));
  EXPECT_EQ(get(folder / "x"), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, CanBeRemovedByAProgramThatEnds) {
  put(folder / "x", "old");
  AtomicFile file(folder / "x");
  put(file.temporary(), "new");
  EXPECT_EQ(files(), 2);
  { const auto held = remove_unfinished_files(); }
  EXPECT_EQ(files(), 1);
  EXPECT_EQ(get(folder / "x"), "old");
  EXPECT_THROW(file.commit(), IoError);
}

}  // namespace
}  // namespace mq
