#include "mq/base/inverse_lists.h"

#include <gtest/gtest.h>

#include <utility>

using namespace mq;

// Every pair that is named is there once, under its target, and targets that nobody names have none.
TEST(InverseLists, HoldWhatWasNamedInOrder) {
  constexpr int sources = 20'000, targets = 777;
  const auto names = [](std::int64_t s, const auto& name) {
    for (std::int64_t k = 0; k < s % 4; ++k) name(int((s * 31 + k * k * 7) % (targets - 1)), std::pair(int(s), int(k)));
  };
  std::vector<std::vector<std::pair<int, int>>> expected(targets);
  for (int s = 0; s < sources; ++s)
    names(s, [&](int target, std::pair<int, int> item) { expected[std::size_t(target)].push_back(item); });

  const auto lists = inverse_lists<std::pair<int, int>>(sources, targets, names);
  ASSERT_EQ(lists.starts.size(), std::size_t(targets) + 1);
  EXPECT_TRUE(expected.back().empty());
  for (int t = 0; t < targets; ++t)
    EXPECT_EQ(std::vector(lists.items.begin() + lists.starts[t], lists.items.begin() + lists.starts[t + 1]),
              expected[std::size_t(t)])
        << t;
}
