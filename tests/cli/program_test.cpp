// What the program says of itself, whatever the verb.
#include "cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Program, SaysItsVersion) {
  const Result result = marquetry({}, {"--version"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, StartsWith("marquetry "));
  EXPECT_EQ(result.error, "");
}

TEST(Program, ListsItsVerbs) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"--help"}, {"-h"}, {"help"}}) {
    const Result result = marquetry({}, words);
    EXPECT_EQ(result.status, 0);
    EXPECT_THAT(result.output, HasSubstr("usage: marquetry VERB"));
  }
}

TEST(Program, RefusesAnUnknownVerb) {
  const Result result = marquetry({}, {"fitler"});
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(result.error, StartsWith("marquetry: there is no verb 'fitler'"));
}

TEST(Program, NoticesThatItsOutputIsLost) {
  const Result result = marquetry({}, {"--help"}, {.standard_output = "/dev/full"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("standard output"));
}

}  // namespace
}  // namespace mq::test
