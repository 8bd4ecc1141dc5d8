// Patterns that grow on an evenly spaced surface first: those of the texels, for less.

#include "mq/filter/pattern_growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "filter/geodesic_squares.h"
#include "mq/base/error.h"
#include "mq/fem/texel_space.h"

namespace mq {
namespace {

using fixtures::places_of;
using fixtures::whole_square;
using std::numbers::pi;

Vector second_of(const Substances& state) {
  Vector v(std::ssize(state) / 2);
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = double(state[std::size_t(2 * i + 1)]);
  return v;
}

/// 2π √(∫ v² / ∫ |∇v|²), v from its mean.
double wave_length(const TexelSpace& space, Vector v) {
  const SparseMatrix M = space.mass();
  v.array() -= (M * v).sum() / M.sum();
  return 2 * pi * std::sqrt(v.dot(M * v) / v.dot(space.stiffness() * v));
}

Substances grown_on(const PatternGrowth& growth, const GrayScottPreset& preset) {
  return growth.grow(gray_scott(preset.rates), growth.seeds(1));
}

/// Of many texels and of few.
TEST(PatternGrowth, GrowsWavesOfTheLengthAskedFor) {
  const GrayScottPreset& spots = gray_scott_presets().front();
  for (const fixtures::CutOptions& options : {whole_square(), fixtures::turned(fixtures::odd_angle, 6)})
    for (const double texels : {36.0, 16.0}) {
      const auto model = fixtures::textured(fixtures::cut_square(options), {{256, 256}});
      const TexelSpace space(model->surface, model->atlas);
      const double wanted = texels * space.scale().texel_spacing;
      const PatternGrowth growth(space, &model->surface, {}, diffusivities(spots, wanted), wanted, 3000);
      EXPECT_EQ(growth.stages().size(), texels > 30 ? 2U : 1U);
      EXPECT_LT(growth.stages().front().steps, 10000);
      const Vector v = second_of(grown_on(growth, spots));
      ASSERT_EQ(v.size(), space.size());
      EXPECT_GE(v.maxCoeff() - v.minCoeff(), 0.2);
      EXPECT_NEAR(wave_length(space, v), wanted, 0.03 * wanted) << texels;
    }
}

/// What is grown is a pattern of the texels: left to itself it goes on about as slowly as one that grew on them, which
/// changes by 0.05 and 0.12 of its deviation.
TEST(PatternGrowth, GrowsWhatTheTexelsKeep) {
  const GrayScottPreset& spots = gray_scott_presets().front();
  for (const fixtures::CutOptions& options : {whole_square(), fixtures::turned(fixtures::odd_angle, 6)}) {
    const auto model = fixtures::textured(fixtures::cut_square(options), {{256, 256}});
    const TexelSpace space(model->surface, model->atlas);
    const double wave = 36 * space.scale().texel_spacing;
    const PatternGrowth growth(space, &model->surface, {}, diffusivities(spots, wave), wave, 3000);
    Substances state = grown_on(growth, spots);
    const Vector v = second_of(state);
    const ReactionDiffusion on_texels(space, diffusivities(spots, wave));
    on_texels.run(gray_scott(spots.rates), int(100 / on_texels.time_step()), state);
    EXPECT_LT((second_of(state) - v).norm(), 0.2 * (v.array() - v.mean()).matrix().norm());
  }
}

TEST(PatternGrowth, StaysOnTheSpaceWhereWavesAreTooShortOrThereIsNoOtherSurface) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  const GrayScottPreset& spots = gray_scott_presets().front();
  for (const auto& [texels, surface] : {std::pair<double, const Surface*>{4, &model->surface}, {30, nullptr}}) {
    const double wave = texels * space.scale().texel_spacing;
    const PatternGrowth growth(space, surface, {}, diffusivities(spots, wave), wave, 50);
    ASSERT_EQ(growth.stages().size(), 1U);
    const Substances grown = grown_on(growth, spots);
    const ReactionDiffusion process(space, diffusivities(spots, wave));
    Substances state = seeded_substances(places_of(space), wave, 1);
    process.run(gray_scott(spots.rates), int(std::ceil(50 / process.time_step())), state);
    EXPECT_EQ(grown, state);
  }
}

TEST(PatternGrowth, TakesTheTimeThatItIsGiven) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{128, 128}});
  const TexelSpace space(model->surface, model->atlas);
  const double wave = 40 * space.scale().texel_spacing;
  const auto growth_of = [&](double time) {
    return PatternGrowth(space, &model->surface, {}, diffusivities(gray_scott_presets().front(), wave), wave, time);
  };
  const PatternGrowth brief = growth_of(10), longer = growth_of(1000);
  ASSERT_EQ(brief.stages().size(), 1U);
  EXPECT_NEAR(brief.stages()[0].steps * brief.stages()[0].process->time_step(), 10, 1);
  ASSERT_EQ(longer.stages().size(), 2U);
  EXPECT_NEAR(longer.stages()[0].steps * longer.stages()[0].process->time_step(), 1000 - 16, 1);
  EXPECT_NEAR(longer.stages()[1].steps * longer.stages()[1].process->time_step(), 16, 1);
  const PatternGrowth endless = growth_of(1e12);
  EXPECT_THROW(grown_on(endless, gray_scott_presets().front()), InvalidInput);
}

}  // namespace
}  // namespace mq
