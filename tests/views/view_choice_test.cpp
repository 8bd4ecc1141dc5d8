// Photographs of a strip of patches in a row, whose colours are known.
#include "mq/views/view_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mq/views/agreement.h"
#include "mq/views/tones.h"

namespace mq {
namespace {

Patches row_of_patches(int count) {
  Patches patches;
  for (int p = 0; p < count; ++p) {
    patches.of.push_back(p), patches.members.push_back(p), patches.offsets.push_back(p);
    if (p > 0) patches.links.push_back({p - 1, p, 1});
  }
  patches.offsets.push_back(count);
  return patches;
}

/// Rows of equal squares.
Patches grid_of_patches(int width, int height) {
  Patches patches = row_of_patches(width * height);
  patches.links.clear();
  for (int p = 0; p < width * height; ++p) {
    if (p % width + 1 < width) patches.links.push_back({p, p + 1, 1});
    if (p + width < width * height) patches.links.push_back({p, p + width, 1});
  }
  return patches;
}

LightColour truth(int p) {
  return {float(0.3 + 0.1 * std::sin(p)), float(0.25 + 0.05 * std::cos(2 * p)), float(0.2 + 0.1 * std::sin(3 * p + 1))};
}

/// All views show all patches, each as bright as `gains` say.
Observations seen_by(int patches, std::span<const LightColour> gains) {
  std::vector<std::vector<Observations::OfPatch>> views(gains.size());
  for (std::size_t v = 0; v < gains.size(); ++v)
    for (int p = 0; p < patches; ++p) {
      LightColour colour = truth(p);
      for (std::size_t c = 0; c < 3; ++c) colour[c] *= gains[v][c];
      views[v].push_back({p, {int(v), float(0.5 + 0.1 * double(v)), 1, colour}});
    }
  return Observations::gather(patches, views);
}

TEST(Agreement, PhotographsOfSomethingElseAreAsFarApartAsIfTheyWereExchanged) {
  constexpr int patches = 400, views = 5;
  const Observations right = seen_by(patches, std::vector<LightColour>(views, {1, 1, 1}));
  Observations wrong = right, plain = right;
  std::mt19937 random(3);
  for (Observation& o : wrong.all) o.colour = truth(int(random() % patches));
  for (Observation& o : plain.all)  // noise alone
    o.colour = {float(0.3 + 0.01 * double(random() % 100) / 100), 0.25F, 0.2F};
  EXPECT_NEAR(agreement(right).here, 0, 1e-6);
  EXPECT_GT(agreement(right).elsewhere, 0.2);
  EXPECT_EQ(agreement(right).share, 1);
  EXPECT_FALSE(agreement(right).is_accidental());
  EXPECT_NEAR(agreement(wrong).here / agreement(wrong).elsewhere, 1, 0.1);
  EXPECT_TRUE(agreement(wrong).is_accidental());
  EXPECT_GT(agreement(plain).here, 0.6 * agreement(plain).elsewhere);
  EXPECT_FALSE(agreement(plain).is_accidental()) << "of one colour it is near wherever it is";

  // A third of the views of another place is what passers-by do.
  Observations some = right;
  for (Observation& o : some.all)
    if (o.view == 1 || (o.view == 3 && random() % 2 == 0)) o.colour = truth(int(random() % patches));
  EXPECT_FALSE(agreement(some).is_accidental());
  // Two views alone cannot tell.
  EXPECT_FALSE(agreement(seen_by(patches, std::vector<LightColour>(2, {1, 1, 1}))).is_accidental());
}

TEST(ViewChoice, ExposuresAreTheInversesOfWhatViewsWereMultipliedBy) {
  const std::vector<LightColour> gains = {{1.3F, 1.1F, 0.9F}, {0.7F, 0.8F, 0.75F}, {1, 1.2F, 1.4F}, {1.1F, 0.9F, 1}};
  const Observations observations = seen_by(400, gains);
  const std::vector<LightColour> found = exposures(observations, 4).gains;
  for (std::size_t c = 0; c < 3; ++c) {
    double logarithms = 0;
    for (std::size_t v = 0; v < 4; ++v) {
      EXPECT_NEAR(found[v][c] * gains[v][c], found[0][c] * gains[0][c], 0.015);  // but for what holds them
      logarithms += std::log(found[v][c]);
    }
    EXPECT_NEAR(logarithms, 0, 1e-5);  // the scene keeps its brightness
  }
}

TEST(ViewChoice, ExposuresDoNotFollowAPasserBy) {
  Observations observations = seen_by(60, std::vector<LightColour>(5, {1, 1, 1}));
  for (int p = 10; p < 30; ++p) observations.of(p)[2].colour = {0.05F, 0.6F, 0.1F};
  for (const LightColour& gain : exposures(observations, 5).gains)
    for (const float g : gain) EXPECT_NEAR(g, 1, 0.01);
}

TEST(ViewChoice, FalloffIsFoundWhereViewsShowAPatchAtSeveralRadii) {
  const std::vector<LightColour> gains = {{1.1F, 1, 0.9F}, {0.8F, 0.8F, 0.8F}, {1, 1.1F, 1.2F}, {1.05F, 1, 1}};
  Observations observations = seen_by(400, gains);
  const Falloff falloff{-0.3, -0.2};
  for (int p = 0; p < 400; ++p)
    for (Observation& o : observations.of(p)) {
      o.radius = float(std::abs(std::sin(0.7 * p + 2 * o.view)));
      for (float& channel : o.colour) channel = float(channel / falloff.correction(o.radius));
    }
  const Exposures found = exposures(observations, 4);
  for (const double radius : {0.3, 0.6, 0.9})
    EXPECT_NEAR(found.falloff.correction(radius), falloff.correction(radius), 0.01 * falloff.correction(radius));
  for (std::size_t v = 1; v < 4; ++v)
    EXPECT_NEAR(found.gains[v][0] * gains[v][0], found.gains[0][0] * gains[0][0], 0.015);

  even_out(found, observations);
  for (int p = 0; p < 400; ++p)
    for (const Observation& o : observations.of(p)) EXPECT_NEAR(o.colour[1], observations.of(p)[0].colour[1], 0.01);
}

/// Of truth(p) in other contrast: light ^ exponent · gain.
Observations toned(int patches, std::span<const double> exponents, std::span<const LightColour> gains, double noise) {
  Observations observations = seen_by(patches, gains);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise);
  for (int p = 0; p < patches; ++p)
    for (Observation& o : observations.of(p)) {
      o.radius = float(std::abs(std::sin(0.7 * p + 2 * o.view)));
      for (std::size_t c = 0; c < 3; ++c)
        o.colour[c] = float(std::pow(truth(p)[c], exponents[std::size_t(o.view)]) * gains[std::size_t(o.view)][c] *
                            std::exp(normal(random)));
    }
  return observations;
}

TEST(Tones, ExponentsAndGainsAreThoseThatViewsWereGiven) {
  const std::vector<double> exponents = {0.8, 1.25, 1, 0.9, 1.1};
  const std::vector<LightColour> gains = {{1.3F, 1.1F, 0.9F}, {0.9F, 1, 0.8F}, {1, 1.1F, 1.2F}, {1.1F, 0.9F, 1}, {1, 1, 1}};
  Observations observations = toned(2000, exponents, gains, 0.01);
  for (int p = 300; p < 500; ++p) observations.of(p)[3].colour = {0.05F, 0.6F, 0.1F};  // a passer-by
  const Exposures found = tones(observations, 5);
  double mean = 0;
  for (std::size_t v = 0; v < 5; ++v) mean += exponents[v] / 5;
  for (std::size_t v = 0; v < 5; ++v) EXPECT_NEAR(found.exponents[v] * exponents[v] / mean, 1, 0.02) << v;
  even_out(found, observations);
  double sum = 0, count = 0;
  for (int p = 500; p < 2000; ++p)
    for (const Observation& o : observations.of(p))
      for (std::size_t c = 0; c < 3; ++c, ++count)
        sum += std::pow(std::log(o.colour[c] / observations.of(p)[4].colour[c]), 2);
  EXPECT_LT(std::sqrt(sum / count), 0.02);  // of noise 0.014
}

TEST(Tones, ViewsOfOneContrastKeepIt) {
  const std::vector<LightColour> gains = {{1.3F, 1.1F, 0.9F}, {0.9F, 1, 0.8F}, {1, 1.1F, 1.2F}, {1.1F, 0.9F, 1}};
  const Observations observations = toned(1000, std::vector<double>(4, 1), gains, 0.03);
  const Exposures with = tones(observations, 4), without = exposures(observations, 4);
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_NEAR(with.exponents[v], 1, 0.015) << v;
    for (std::size_t c = 0; c < 3; ++c) {
      const double middle = 0.25;  // where the exponent's error costs nothing
      EXPECT_NEAR(with.evened(int(v), 0, {float(middle), float(middle), float(middle)})[c],
                  middle * without.gains[v][c], 0.01 * middle);
      EXPECT_EQ(without.exponents[v], 1);
    }
  }
}

TEST(Tones, WhatTellsNothingOfContrastLeavesIt) {
  std::vector<std::vector<Observations::OfPatch>> views(3);
  for (int p = 0; p < 200; ++p) {  // one colour, and a view that shares nothing
    views[0].push_back({p, {0, 1, 1, {0.2F, 0.2F, 0.2F}}});
    views[1].push_back({p, {1, 1, 1, {0.4F, 0.4F, 0.4F}}});
    views[2].push_back({p + 200, {2, 1, 1, {0.9F, 0.9F, 0.9F}}});
  }
  const Exposures found = tones(Observations::gather(400, views), 3);
  EXPECT_NEAR(found.exponents[0], 1, 0.02);
  EXPECT_NEAR(found.exponents[1], 1, 0.02);
  EXPECT_NEAR(found.evened(0, 0, {0.2F, 0.2F, 0.2F})[0], found.evened(1, 0, {0.4F, 0.4F, 0.4F})[0], 0.005);
  EXPECT_EQ(found.exponents[2], 1);
  EXPECT_EQ(found.gains[2], (LightColour{1, 1, 1}));
}

TEST(ViewChoice, AViewThatSharesNothingKeepsItsLight) {
  std::vector<std::vector<Observations::OfPatch>> views(3);
  for (int p = 0; p < 200; ++p) {
    views[0].push_back({p, {0, 1, 1, {0.2F, 0.2F, 0.2F}}});
    views[1].push_back({p, {1, 1, 1, {0.4F, 0.4F, 0.4F}}});
    views[2].push_back({p + 200, {2, 1, 1, {0.9F, 0.9F, 0.9F}}});
  }
  const auto found = exposures(Observations::gather(400, views), 3).gains;
  EXPECT_NEAR(found[0][0] / found[1][0], 2, 0.02);  // but for what holds them
  EXPECT_EQ(found[2], (LightColour{1, 1, 1}));
}

/// Of view 1 what is hidden and what touches it are rejected, and nothing else.
void expect_rejected_with_border(const Observations& observations, int width, const auto& hidden) {
  for (int p = 0; p < observations.patches(); ++p) {
    const int x = p % width, y = p / width;
    const bool border = hidden(x - 1, y) || hidden(x + 1, y) || hidden(x, y - 1) || hidden(x, y + 1);
    for (const Observation& o : observations.of(p))
      EXPECT_EQ(o.rejected, o.view == 1 && (hidden(x, y) || border)) << x << ", " << y << " in " << o.view;
  }
}

TEST(ViewChoice, APasserByIsRejectedWithItsBorderAndNothingElse) {
  constexpr int width = 20, height = 12;
  const Patches patches = grid_of_patches(width, height);
  Observations observations = seen_by(width * height, std::vector<LightColour>(5, {1, 1, 1}));
  const auto hidden = [](int x, int y) { return x >= 5 && x < 11 && y >= 3 && y < 9; };
  const auto changed = [&](int p) { return hidden(p % width, p / width); };
  for (int p = 0; p < width * height; ++p)
    if (changed(p)) observations.of(p)[1].colour = {0.05F, 0.6F, 0.1F};
  reject(patches, {}, observations);
  expect_rejected_with_border(observations, width, hidden);
}

/// Beside a place where three views tell, two suffice; there the other is not rejected.
TEST(ViewChoice, APasserByIsFollowedToWhereTwoViewsAloneShowThePlace) {
  constexpr int width = 20, height = 12;
  const Patches patches = grid_of_patches(width, height);
  std::vector<std::vector<Observations::OfPatch>> views(4);
  const auto hidden = [](int x, int y) { return x >= 5 && x < 15 && y >= 3 && y < 9; };
  for (int p = 0; p < width * height; ++p)
    for (int v = 0; v < 4; ++v) {
      const int x = p % width, y = p / width;
      if (v >= 2 && x >= 9) continue;
      const LightColour passer_by = {0.05F, 0.6F, 0.1F};
      views[std::size_t(v)].push_back({p, {v, 0.5F, 1, v == 1 && hidden(x, y) ? passer_by : truth(p)}});
    }
  Observations observations = Observations::gather(width * height, views);
  reject(patches, {}, observations);
  expect_rejected_with_border(observations, width, hidden);
}

/// Two views of a grid, of which one is changed somewhere.
Observations two_views(int width, int height, int wrong, const auto& changed) {
  Observations observations = seen_by(width * height, std::vector<LightColour>(2, {1, 1, 1}));
  for (int p = 0; p < width * height; ++p)
    observations.of(p)[std::size_t(wrong)].colour = changed(p % width, p / width, truth(p));
  return observations;
}

/// Four views of a row, but of patches 40 to 59 one alone, which shows 30 to 49 times `change`.
Observations seen_by_one_beyond(const LightColour& change) {
  const Observations all = seen_by(60, std::vector<LightColour>(4, {1, 1, 1}));
  std::vector<std::vector<Observations::OfPatch>> views(4);
  for (int p = 0; p < 60; ++p)
    for (Observation o : all.of(p)) {
      o.colour = {0.3F, 0.25F, 0.2F};
      if (o.view == 0 && p >= 30 && p < 50)
        for (std::size_t c = 0; c < 3; ++c) o.colour[c] *= change[c];
      if (o.view == 0 || p < 40) views[std::size_t(o.view)].push_back({p, o});
    }
  return Observations::gather(60, views);
}

TEST(ViewChoice, APasserByIsFollowedToWhereNoOtherViewShowsThePlaceAndNothingIsLeftThere) {
  const Patches patches = row_of_patches(60);
  Observations observations = seen_by_one_beyond({0.2F, 0.3F, 0.8F});
  reject(patches, {}, observations);
  const std::vector<int> chosen = choose_views(patches, observations);
  for (int p = 0; p < 60; ++p) {
    if (p >= 30 && p < 50) EXPECT_TRUE(observations.of(p)[0].rejected) << p;
    EXPECT_EQ(chosen[std::size_t(p)] < 0, p >= 40 && p < 50) << p;
  }
}

/// Patches half dark, half bright, of which four views show both halves alike; of one half or the other they show more.
TEST(ViewChoice, ViewsThatShowOtherPlacesOfAPatchAreNotRejected) {
  const Patches patches = row_of_patches(20);
  const std::vector<LightColour> gains(5, {1, 1, 1});
  const auto with_halves = [&](bool prints) {
    Observations observations = seen_by(20, gains);
    for (int p = 5; p < 15; ++p)
      for (Observation& o : observations.of(p)) {
        const double dark = 0.05, bright = 0.6, mean = o.view < 2 ? 0.1 : 0.5;  // as these weigh the halves
        o.colour = {float(mean), float(mean), float(mean)};
        for (int k = 0; prints && k < Print::places; ++k) o.print.put(k, k < 3 ? dark : bright, mean);
      }
    return observations;
  };
  Observations same = with_halves(true), other = with_halves(false);
  reject(patches, {}, same), reject(patches, {}, other);
  for (const Observation& o : same.all) EXPECT_FALSE(o.rejected);
  for (int p = 5; p < 15; ++p)
    for (const Observation& o : other.of(p)) EXPECT_EQ(o.rejected, o.view < 2) << p;
}

/// A patch at an outline, with the background in it: nobody stands in front of what lies beside it.
TEST(ViewChoice, WhatIsHardlyShownIsNotFollowed) {
  const Patches patches = row_of_patches(60);
  for (const float quality : {0.5F, 0.02F}) {
    Observations observations = seen_by_one_beyond({0.2F, 0.3F, 0.8F});
    for (int p = 30; p < 40; ++p) observations.of(p)[0].quality = quality;
    reject(patches, {}, observations);
    for (int p = 30; p < 40; ++p) EXPECT_TRUE(observations.of(p)[0].rejected) << p;
    for (int p = 42; p < 50; ++p) EXPECT_EQ(observations.of(p)[0].rejected, quality == 0.5F) << p;
  }
}

TEST(ViewChoice, UndecidedIsWhatTwoViewsAloneShowEachOtherwise) {
  Observations observations = seen_by(10, std::vector<LightColour>(3, {1, 1, 1}));
  for (int p = 2; p < 8; ++p) observations.of(p)[0].rejected = true;
  for (int p = 4; p < 10; ++p)
    for (float& channel : observations.of(p)[1].colour) channel *= 2;
  const std::vector<char> found = undecided(row_of_patches(10), observations, {});
  for (int p = 0; p < 10; ++p) EXPECT_EQ(bool(found[std::size_t(p)]), p == 5 || p == 6) << p;  // with two beside them
}

TEST(ViewChoice, LightAndShadowAreNotFollowedToWhereNoOtherViewShowsThePlace) {
  const Patches patches = row_of_patches(60);
  Observations observations = seen_by_one_beyond({0.4F, 0.4F, 0.4F});
  reject(patches, {}, observations);
  EXPECT_TRUE(observations.of(35)[0].rejected);
  for (int p = 40; p < 60; ++p) EXPECT_FALSE(observations.of(p)[0].rejected) << p;
}

TEST(ViewChoice, APasserByIsFollowedOverPatchesThatItsViewDoesNotShow) {
  const Patches patches = row_of_patches(60);
  const Observations whole = seen_by_one_beyond({0.2F, 0.3F, 0.8F});
  std::vector<std::vector<Observations::OfPatch>> views(4);
  for (int p = 0; p < 60; ++p)
    for (const Observation& o : whole.of(p))
      if (p < 40 || p >= 44) views[std::size_t(o.view)].push_back({p, o});
  Observations observations = Observations::gather(60, views);
  reject(patches, {}, observations);
  for (int p = 44; p < 60; ++p) EXPECT_EQ(observations.of(p)[0].rejected, p < 50) << p;
}

TEST(ViewChoice, TwoPassersByOfOneColourDoNotOutvoteOthersThatGoOn) {
  const Patches patches = row_of_patches(30);
  Observations observations = seen_by(30, std::vector<LightColour>(4, {1, 1, 1}));
  for (int p = 0; p < 30; ++p)
    for (Observation& o : observations.of(p)) {
      const bool passer_by = (o.view == 0 && p >= 5 && p < 17) || (o.view == 1 && p >= 12 && p < 25);
      o.colour = passer_by ? LightColour{0.05F, 0.06F, 0.1F} : LightColour{0.3F, 0.25F, 0.2F};
    }
  reject(patches, {}, observations);
  for (int p = 5; p < 25; ++p) {
    if (p < 17) EXPECT_TRUE(observations.of(p)[0].rejected) << p;
    if (p >= 12) EXPECT_TRUE(observations.of(p)[1].rejected) << p;
    EXPECT_FALSE(observations.of(p)[2].rejected || observations.of(p)[3].rejected) << p;
  }
}

TEST(ViewChoice, OfTwoViewsTheOneThatChangesWhereTheyBeginToDisagreeIsRejected) {
  constexpr int width = 20, height = 12;
  const auto passer_by = [](int x, int y, LightColour colour) {
    return x >= 5 && x < 11 && y >= 3 && y < 9 ? LightColour{0.05F, 0.6F, 0.1F} : colour;
  };
  const auto highlight = [](int x, int y, LightColour colour) {
    const auto light = float(0.5 * std::exp(-(std::pow(x - 8, 2) + std::pow(y - 6, 2)) / 6));
    return LightColour{colour[0] + light, colour[1] + light, colour[2] + light};
  };
  const auto expect_rejected = [](Observations observations, int wrong) {
    reject(grid_of_patches(width, height), {}, observations);
    for (int p = 0; p < width * height; ++p) EXPECT_FALSE(observations.of(p)[std::size_t(1 - wrong)].rejected) << p;
    for (const int p : {6 * width + 8, 5 * width + 7, 6 * width + 9})
      EXPECT_TRUE(observations.of(p)[std::size_t(wrong)].rejected) << p;
    EXPECT_FALSE(observations.of(17)[std::size_t(wrong)].rejected);
  };
  for (const int wrong : {0, 1}) {
    expect_rejected(two_views(width, height, wrong, passer_by), wrong);
    expect_rejected(two_views(width, height, wrong, highlight), wrong);
  }
}

/// Sharper detail, whose dark parts are darker and bright ones brighter, is no reason to leave out either.
TEST(ViewChoice, OfTwoViewsTheSharperOneIsNotRejected) {
  constexpr int width = 20, height = 12;
  Observations observations = two_views(width, height, 0, [](int x, int y, LightColour colour) {
    const float by = x >= 5 && x < 11 && y >= 3 && y < 9 ? ((x + y) % 2 ? 1.6F : 0.6F) : 1.0F;
    return LightColour{by * colour[0], by * colour[1], by * colour[2]};
  });
  reject(grid_of_patches(width, height), {}, observations);
  for (const Observation& o : observations.all) EXPECT_FALSE(o.rejected);
}

TEST(ViewChoice, WhatIsRejectedSaysNothingOfExposure) {
  Observations observations = seen_by(60, std::vector<LightColour>(2, {1, 1, 1}));
  for (int p = 10; p < 50; ++p)
    observations.of(p)[1].colour = {0.05F, 0.6F, 0.1F}, observations.of(p)[1].rejected = true;
  for (const LightColour& gain : exposures(observations, 2).gains)
    for (const float g : gain) EXPECT_NEAR(g, 1, 0.001);
}

TEST(ViewChoice, OfTwoViewsThatDisagreeNeitherIsRejected) {
  Observations observations = seen_by(10, std::vector<LightColour>{{1, 1, 1}, {3, 3, 3}});
  reject(row_of_patches(10), {}, observations);
  for (const Observation& o : observations.all) EXPECT_FALSE(o.rejected);
}

TEST(ViewChoice, BlurredAndRejectedViewsAreNotChosenAndSmoothnessJoins) {
  const Patches patches = row_of_patches(30);
  Observations observations = seen_by(30, std::vector<LightColour>(3, {1, 1, 1}));
  for (Observation& o : observations.all) {
    if (o.view == 2) o.detail = 0.2F;  // the best by far, but blurred
    o.quality = o.view == 2 ? 1 : 0.5F;
  }
  for (int p = 0; p < 15; ++p) observations.of(p)[0].rejected = true;
  observations.of(20)[1].quality = 0.55F;  // one patch alone that the other shows a little better
  const std::vector<int> chosen = choose_views(patches, observations);
  for (int p = 0; p < 30; ++p) EXPECT_EQ(chosen[std::size_t(p)], 1) << p;
  const std::vector<int> single = choose_views(patches, observations, {.smoothness = 0});
  EXPECT_EQ(single[20], 1);
  EXPECT_EQ(single[25], 0);
}

/// Two views, of which each shows one end better. Between them are letters, which one shows a little beside the other, but
/// at a gap.
TEST(ViewChoice, BordersGoThroughPlainPlaces) {
  constexpr int count = 20, gap = 6;
  const Patches patches = row_of_patches(count);
  Observations observations = seen_by(count, std::vector<LightColour>(2, {1, 1, 1}));
  for (int p = 0; p < count; ++p)
    for (Observation& o : observations.of(p)) {
      o.quality = float(0.7 + 0.01 * (o.view == 0 ? count - p : p));
      for (int place = 0; place < Print::places; ++place) {
        const bool dark = p != gap && p != gap + 1 && place % 2 == o.view;
        o.print.put(place, dark ? 0.1 : 0.3, 0.2);
      }
    }
  std::vector<int> wanted(count, 1), middle = wanted;
  std::fill_n(wanted.begin(), gap + 1, 0), std::fill_n(middle.begin(), count / 2 + 1, 0);
  EXPECT_EQ(choose_views(patches, observations), wanted);
  const std::vector<int> whatever_print = choose_views(patches, observations, {.print = 0});
  EXPECT_NEAR(double(std::ranges::count(whatever_print, 0)), count / 2, 1);
}

TEST(ViewChoice, PrintIsHeldAgainstTheMeanOfWhatIsNotRejectedWhateverExposureAndContrast) {
  Observations observations = seen_by(1, std::vector<LightColour>(4, {1, 1, 1}));
  constexpr int shown = 4;
  const auto own = [](int view, int place) {  // the third is out of focus, the last one shows something else
    const double common = std::log((0.2 + 0.1 * place) / 0.35);
    return view == 3 ? 0.4 * (place % 2) : view == 2 ? common / 2 : common;
  };
  for (Observation& o : observations.all) {
    o.quality = 1;
    const double gain = 1 + o.view;
    for (int place = 0; place < shown; ++place) o.print.put(place, gain * std::exp(own(o.view, place)), gain);
  }
  observations.all[3].rejected = true;
  const std::vector<float> found = print_deviations(observations.of(0));
  for (std::size_t v = 0; v < 3; ++v) EXPECT_LT(found[v], 0.03) << v;
  double of_own = 0, both = 0, of_mean = 0;
  for (int place = 0; place < shown; ++place)
    of_own += std::pow(own(3, place), 2), both += own(3, place) * own(0, place), of_mean += std::pow(own(0, place), 2);
  EXPECT_NEAR(found[3], std::sqrt((of_own - both * both / of_mean) / shown), 0.03);
  EXPECT_FALSE(observations.all[0].print.at(shown)) << "it is not shown";
}

/// View 1 is a fifth worse than view 0 everywhere, and rejected in the middle.
TEST(ViewChoice, KeepsTheViewOfTheFrameBeforeWhereOthersAreHardlyBetter) {
  const Patches patches = grid_of_patches(9, 9);
  Observations observations = seen_by(81, std::vector<LightColour>(2, {1, 1, 1}));
  for (Observation& o : observations.all) o.quality = o.view == 0 ? 1 : 0.8F;
  ChooseOptions options{.smoothness = 0, .before = std::vector<int>(81, 1)};
  EXPECT_EQ(choose_views(patches, observations, options), std::vector<int>(81, 1));
  observations.all[2 * 40 + 1].rejected = true;
  EXPECT_EQ(choose_views(patches, observations, options)[40], 0);
  options.steady = 0.1;
  EXPECT_EQ(choose_views(patches, observations, options), std::vector<int>(81, 0));
}

/// Where a surface is plain all views have the same detail, that of noise.
TEST(ViewChoice, WhatIsBlurredIsKnownOnPlainPatchesByThoseAround) {
  const Patches patches = grid_of_patches(12, 12);
  Observations observations = seen_by(144, std::vector<LightColour>(4, {1, 1, 1}));
  for (int p = 0; p < 144; ++p)
    for (Observation& o : observations.of(p)) {
      const bool plain = p % 3 != 0 || p / 12 % 3 != 0;
      o.detail = plain ? 0.02F : o.view == 2 ? 0.1F : 0.4F;
      o.quality = o.view == 2 ? 1 : o.view == 1 ? 0.6F : 0.5F;
    }
  EXPECT_GT(std::ranges::count(choose_views(patches, observations), 2), 100) << "wanted something to get right";
  pool_details(patches, observations);
  for (int p = 0; p < 144; ++p) {
    EXPECT_LT(sharpness(observations.of(p))[2], 0.35F) << p;
    EXPECT_FLOAT_EQ(sharpness(observations.of(p))[1], 1) << p;
  }
  EXPECT_EQ(choose_views(patches, observations), std::vector<int>(144, 1));
}

TEST(ViewChoice, OffsetsLeadToTheMeanOfWhatAgrees) {
  Observations observations = seen_by(4, std::vector<LightColour>{{1, 1, 1}, {1.2F, 1.2F, 1.2F}, {9, 9, 9}});
  for (int p = 0; p < 4; ++p) observations.of(p)[2].rejected = true;
  for (Observation& o : observations.of(3)) o.rejected = true;
  const auto agreed = agreed_colours(observations);
  for (int p = 0; p < 3; ++p)
    for (std::size_t c = 0; c < 3; ++c) {
      const double own = truth(p)[c];
      ASSERT_TRUE(agreed[std::size_t(p)]);
      EXPECT_NEAR((*agreed[std::size_t(p)])[c], (0.5 * own + 0.6 * 1.2 * own) / 1.1, 1e-6);
    }
  EXPECT_FALSE(agreed[3]) << "all of it is rejected";
}

}  // namespace
}  // namespace mq
