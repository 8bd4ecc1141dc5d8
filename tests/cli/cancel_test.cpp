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
                                  {.interrupt = RunOptions::Interrupt::when_it_speaks});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr("cancelled"));
  for (const std::string& name : folder.names())
    EXPECT_TRUE(name == "out" || std::ranges::count(before, name)) << name;
}

}  // namespace
}  // namespace mq::test
