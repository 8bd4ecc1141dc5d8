#include "mq/base/option_names.h"

#include <gtest/gtest.h>

namespace mq {
namespace {

TEST(OptionName, IsTheFieldUnlessTheProgramSaysOtherwise) {
  EXPECT_EQ(option_name("longest_edge"), "longest_edge");
  set_option_names([](std::string_view field) { return "--" + std::string(field); });
  EXPECT_EQ(option_name("weld") + " none", "--weld none");
  set_option_names({});
  EXPECT_EQ(option_name("weld"), "weld");
}

}  // namespace
}  // namespace mq
