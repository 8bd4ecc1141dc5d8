#include "mq/linear/row_set.h"

#include <gtest/gtest.h>

#include <set>


namespace mq {
namespace {

TEST(RowSet, HoldsWhatWasAddedInIncreasingOrder) {
  RowSet set(1000);
  for (int round = 0; round < 3; ++round) {  // as empty after `clear` as at first
    EXPECT_EQ(set.count(), 0);
    EXPECT_TRUE(set.rows().empty());
    std::set<int> wanted;
    for (int i = 0; i < 400; ++i) {
      const int row = (i * i * 37 + 61 * round) % 1000;
      EXPECT_EQ(set.add(row), wanted.insert(row).second);
    }
    EXPECT_EQ(set.rows(), std::vector<int>(wanted.begin(), wanted.end()));
    EXPECT_EQ(set.count(), std::ssize(wanted));
    for (int row = 0; row < 1000; ++row) ASSERT_EQ(set.has(row), wanted.contains(row));
    set.clear();
  }
}

TEST(RowSet, TakesConsecutiveRowsAsItTakesThemOneByOne) {
  RowSet set(1000), one_by_one(1000);
  for (int i = 0; i < 60; ++i) {
    const RowSet::Segment some{(i * 37) % 870, (i * i) % 131};
    set.add(some);
    for (int k = 0; k < some.count; ++k) one_by_one.add(some.first + k);
    ASSERT_EQ(set.rows(), one_by_one.rows()) << i;
    ASSERT_EQ(set.count(), one_by_one.count()) << i;
    if (i % 20 == 19) set.clear(), one_by_one.clear();
  }
  set.add(RowSet::Segment{64, 64});
  set.add(RowSet::Segment{0, 1000});
  EXPECT_EQ(set.count(), 1000);
  set.clear();
  set.add(RowSet::Segment{999, 1});
  EXPECT_EQ(set.rows(), std::vector<int>{999});
}

TEST(RowSet, SegmentsAreItsRows) {
  const std::vector<int> rows = {0, 1, 2, 63, 64, 65, 128, 200, 201};
  std::vector<int> again;
  const std::vector<RowSet::Segment> segments = segments_of(rows);
  EXPECT_EQ(segments.size(), 4U);
  for (const RowSet::Segment& s : segments)
    for (int i = 0; i < s.count; ++i) again.push_back(s.first + i);
  EXPECT_EQ(again, rows);
  EXPECT_TRUE(segments_of({}).empty());
}

}  // namespace
}  // namespace mq
