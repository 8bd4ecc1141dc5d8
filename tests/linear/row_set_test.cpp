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
