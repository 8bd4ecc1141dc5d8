// Texels that hang together.
#include "mq/atlas/texel_patches.h"

#include <gtest/gtest.h>

namespace mq {
namespace {

TEST(TexelPatches, HangTogetherAtCornersAndOverRows) {
  const TexelGrid grid({{8, 4}});
  // A ring around (1, 1), which joins late, a texel at its corner, and two far from it; one is named twice.
  const std::vector<std::int64_t> texels = {0, 2, 8, 10, 16, 17, 18, 27, 6, 7, 7};
  const std::vector<Defect::Place> places = texel_patches(texel_runs(grid, texels));
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0].texels, 8);
  EXPECT_EQ(places[1].texels, 2);
  EXPECT_EQ(places[1].row, 0);
  EXPECT_GE(places[1].column, 6);
}

TEST(TexelPatches, AreNamedByATexelOfTheirOwn) {
  const TexelGrid grid({{64, 64}});
  std::vector<std::int64_t> hook;  // its middle is no part of it
  for (int i = 0; i < 20; ++i) {
    hook.push_back(5 * 64 + 10 + i);
    hook.push_back((5 + i) * 64 + 10);
  }
  const std::vector<Defect::Place> places = texel_patches(texel_runs(grid, hook));
  ASSERT_EQ(places.size(), 1U);
  EXPECT_EQ(places[0].texels, 39);
  EXPECT_TRUE(places[0].column == 10 || places[0].row == 5) << places[0].column << ", " << places[0].row;
}

TEST(TexelPatches, StayApartInDifferentTexturesAndColumns) {
  const TexelGrid grid({{4, 2}, {4, 2}});
  const std::vector<std::int64_t> texels = {4, 6, 8, 9};  // the last row of the first, the first of the second
  const std::vector<Defect::Place> places = texel_patches(texel_runs(grid, texels));
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(places[0].texture, 1);
  EXPECT_EQ(places[0].texels, 2);
  EXPECT_EQ(places[0].row, 0);
  EXPECT_EQ(places[1].row, 1);
  EXPECT_EQ(places[1].column, 0);
  EXPECT_EQ(places[2].column, 2);
}

TEST(TexelPatches, OfNothingAreNone) {
  EXPECT_TRUE(texel_patches({}).empty());
  Defect defect;
  list_places(TexelGrid({{4, 4}}), {}, defect);
  EXPECT_EQ(defect.place_count, 0);
}

}  // namespace
}  // namespace mq
