#include "mq/base/memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "mq/base/error.h"

namespace mq {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Memory, IsMoreThanNothingAndLessThanEverything) {
  EXPECT_GT(available_memory(), 1 << 20);
  EXPECT_LT(available_memory(), std::int64_t(1) << 50);
}

TEST(Memory, HasAPeakThatStaysAfterItIsGivenBack) {
  constexpr std::int64_t much = 200 << 20;
  const std::int64_t before = peak_memory();
  EXPECT_GT(before, 1 << 20);
  { const std::vector<char> bytes(std::size_t(before + much), 'x'); }
  EXPECT_GE(peak_memory(), before + much);
  EXPECT_LT(peak_memory(), 2 * before + much + (50 << 20));
}

TEST(Memory, IsRequiredInWords) {
  EXPECT_NO_THROW(require_memory(1, "a byte", "buy one"));
  EXPECT_THAT([] { require_memory(std::int64_t(1) << 60, "this", "use less"); },
              ThrowsMessage<OutOfMemory>(AllOf(HasSubstr("this needs about 1152921504.6 GB"),
                                               HasSubstr("GB are free: use less"))));
}

}  // namespace
}  // namespace mq
