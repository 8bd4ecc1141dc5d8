#include "mq/io/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>

#include "io/folder.h"

namespace mq {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class TemporaryFolders : public FolderTest {
 protected:
  TemporaryFolders() {
    if (const char* named = std::getenv("TMPDIR")) before_ = named;
    ::setenv("TMPDIR", folder.c_str(), 1);
  }
  ~TemporaryFolders() override {
    before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR");
  }

 private:
  std::optional<std::string> before_;
};

TEST_F(TemporaryFolders, AreEachTheirOwnAndGoWithWhatIsInThem) {
  {
    const TemporaryFolder one("a-", "this"), other("a-", "that");
    EXPECT_NE(one.path(), other.path());
    EXPECT_EQ(one.path().parent_path(), folder);
    EXPECT_THAT(one.path().filename().string(), StartsWith("a-"));
    std::ofstream(one / "file") << "text";
    EXPECT_EQ(files(), 3);
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(TemporaryFolders, AreMadeInTmpWhereNoPlaceIsNamed) {
  ::setenv("TMPDIR", "", 1);
  EXPECT_EQ(temporary_place(), "/tmp");
  ::unsetenv("TMPDIR");
  EXPECT_EQ(temporary_place(), "/tmp");
}

TEST_F(TemporaryFolders, SayWhereTheyCannotBeMade) {
  ::setenv("TMPDIR", (folder / "none").c_str(), 1);
  EXPECT_THAT(io_error_of([] { const TemporaryFolder one("a-", "the video"); }),
              AllOf(HasSubstr("none: no folder for the video can be made here"), HasSubstr("TMPDIR names another")));
}

}  // namespace
}  // namespace mq
