#include "mq/evolving/detail/survival.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mq/base/random.h"

namespace mq {
namespace {

constexpr auto seen = KnownLife::End::seen, to_come = KnownLife::End::to_come;
constexpr int ever = 100000;

TEST(Survival, LetsAllLiveOnWhereNothingEnded) {
  EXPECT_EQ(Survival({}).expected_after(3, 20), 20);
  EXPECT_EQ(Survival({{5, to_come}, {9, to_come}}).expected_after(5, 20), 20);
  EXPECT_EQ(Survival({{5, to_come}, {9, to_come}}).expected_after(50, 20), 20);
}

TEST(Survival, KnowsLivesOfOneLength) {
  const Survival survival({{5, seen}, {5, seen}, {5, seen}});
  for (int age = 1; age <= 5; ++age) EXPECT_EQ(survival.expected_after(age, ever), 5 - age);
  EXPECT_EQ(survival.expected_after(1, 2), 2);
}

TEST(Survival, HasOneExpectationForEveryAgeWhereTheHazardIsConstant) {
  // Half of 1,024 lives end after each frame; the last two are there in the tenth, and may go on.
  std::vector<KnownLife> lives = {{10, to_come}, {10, to_come}};
  for (int age = 1; age <= 9; ++age) lives.insert(lives.end(), 1024 >> age, {age, seen});
  const Survival survival(lives);
  for (int age = 1; age <= 20; ++age) {
    EXPECT_NEAR(survival.expected_after(age, ever), 1, 1e-12) << age;
    EXPECT_NEAR(survival.expected_after(age, 3), 0.875, 1e-12) << age;
  }
}

TEST(Survival, CountsWhatStillLivesForAsLongAsItWasSeen) {
  // h(1) = 0/8, h(2) = 3/7, h(3) = 0/4, h(4) = 4/4: of the one that was seen for two frames the second is not known.
  const Survival survival({{2, seen}, {2, seen}, {2, seen}, {2, to_come}, {4, seen}, {4, seen}, {4, seen}, {4, seen}});
  EXPECT_NEAR(survival.expected_after(1, ever), 1 + 4 / 7.0 + 4 / 7.0, 1e-12);
  EXPECT_NEAR(survival.expected_after(2, ever), 4 / 7.0 + 4 / 7.0, 1e-12);
  EXPECT_NEAR(survival.expected_after(3, ever), 1, 1e-12);
}

TEST(Survival, IsNotMisledByWhereTheWindowEnds) {
  // Lives of 12 frames in the mean, without memory, of which most are cut by the end of what is known.
  const Random random(7);
  std::vector<KnownLife> lives;
  double cut = 0;
  for (int i = 0; i < 40000; ++i) {
    const int frames = 1 + int(std::log(random.uniform(2 * i)) / std::log(1 - 1 / 12.0));
    const int known = 1 + int(15 * random.uniform(2 * i + 1));
    lives.push_back(frames < known ? KnownLife{frames, seen} : KnownLife{known, to_come});
    cut += frames >= known;
  }
  EXPECT_GT(cut / 40000, 0.5);
  const Survival survival(lives);
  for (const int age : {1, 5, 10}) EXPECT_NEAR(survival.expected_after(age, ever), 11, 0.4) << age;
}

TEST(Survival, IsLongerForWhatHasLivedLongWhereManyEndEarly) {
  std::vector<KnownLife> lives(90, {2, seen});
  lives.insert(lives.end(), 10, {50, to_come});
  const Survival survival(lives);
  EXPECT_LT(survival.expected_after(1, 40), survival.expected_after(3, 40) / 2);
}

}  // namespace
}  // namespace mq
