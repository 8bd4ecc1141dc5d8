// Pictures of sizes that a file of cameras does not say, one of which is not as it was.
#include "mq/io/detail/unlike_sizes.h"

#include <gmock/gmock.h>

namespace mq {
namespace {

using testing::Each;

/// Five of 400 × 300 and another one, and what is said of that.
SizeVerdict verdict_on(const UnsizedPicture& other) {
  std::vector<UnsizedPicture> pictures;
  for (int k = 0; k < 5; ++k) pictures.push_back({.width = 400, .height = 300, .lies = false, .focal = 500.0 + k});
  pictures.push_back(other);
  const UsualSize usual(pictures);
  EXPECT_EQ(usual.width, 400);
  EXPECT_EQ(usual.focal, 502);
  const std::vector<SizeVerdict> verdicts = judged_sizes(pictures, usual);
  EXPECT_THAT(std::vector(verdicts.begin(), verdicts.end() - 1), Each(SizeVerdict::as_stored));
  return verdicts.back();
}

TEST(UnlikeSizes, TellWhatBecameOfAPicture) {
  EXPECT_EQ(verdict_on({400, 300, true, 500}), SizeVerdict::as_stored);  // turned it would be unlike the others
  EXPECT_EQ(verdict_on({300, 400, true, 500}), SizeVerdict::upright);
  EXPECT_EQ(verdict_on({300, 400, false, 500}), SizeVerdict::on_its_side);
  EXPECT_EQ(verdict_on({200, 150, false, 500}), SizeVerdict::scaled);
  EXPECT_EQ(verdict_on({200, 150, false, 250}), SizeVerdict::as_stored);  // its camera is of that size
  EXPECT_EQ(verdict_on({350, 300, false, 510}), SizeVerdict::cropped);
  EXPECT_EQ(verdict_on({350, 300, false, 700}), SizeVerdict::unlike);
}

TEST(UnlikeSizes, AreNotDoubtedWhereSeveralHaveThem) {
  std::vector<UnsizedPicture> pictures(5, {400, 300, false, 500});
  pictures.insert(pictures.end(), {{300, 400, false, 500}, {300, 400, false, 500}, {350, 300, false, 500},
                                   {350, 300, false, 500}});
  EXPECT_THAT(judged_sizes(pictures, UsualSize(pictures)), Each(SizeVerdict::as_stored));
  pictures.resize(2, {400, 300, false, 500});
  pictures.insert(pictures.end(), {{350, 300, false, 500}, {320, 300, false, 500}});
  EXPECT_EQ(UsualSize(pictures).width, 0);  // half of them are not most
  EXPECT_THAT(judged_sizes(pictures, UsualSize(pictures)), Each(SizeVerdict::as_stored));
}

}  // namespace
}  // namespace mq
