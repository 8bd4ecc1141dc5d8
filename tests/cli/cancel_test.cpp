#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"

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
  for (const std::string& name : folder.names())
    EXPECT_TRUE(name == "out" || std::ranges::count(before, name)) << name;
}

TEST(Cancelling, EndsAtOnceWhenAskedAgain) {
  const Folder folder;
  write_strip(folder, 2000, 1500);
  const auto before = folder.names();
  // No factorisation looks up; this one takes longer than the test.
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "0", "--solver", "direct"},
                {.interrupt_at = {"analysis", "press Ctrl-C again"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("finishing the analysis; press Ctrl-C again"));
  EXPECT_THAT(result.error, testing::HasSubstr("stopped at once"));
  EXPECT_EQ(folder.names(), before);
}

}  // namespace
}  // namespace mq::test
