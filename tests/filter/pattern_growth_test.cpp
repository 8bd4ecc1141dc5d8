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

TEST(PatternGrowth, GrowsWavesOfTheLengthAskedFor) {
  const GrayScottPreset& spots = gray_scott_presets().front();
  for (const fixtures::CutOptions& options : {whole_square(), fixtures::turned(fixtures::odd_angle, 6)}) {
    const auto model = fixtures::textured(fixtures::cut_square(options), {{256, 256}});
    const TexelSpace space(model->surface, model->atlas);
    const double wanted = 36 * space.scale().texel_spacing, time = 3000;
    const PatternGrowth growth(space, &model->surface, diffusivities(spots, wanted), wanted, time);
    const auto stages = growth.stages();
    ASSERT_EQ(stages.size(), 2U);
    const Substances grown = growth.grow(gray_scott(spots.rates), growth.seeds(1));
    const Vector v = second_of(grown);
    EXPECT_GE(v.maxCoeff() - v.minCoeff(), 0.2);
    EXPECT_NEAR(wave_length(space, v), wanted, 0.02 * wanted);
    const ReactionDiffusion& on_texels = *stages.back().process;
    EXPECT_LT(growth.cost(), 0.05 * time / on_texels.time_step());

    // What is grown is a pattern of the texels: left to itself it goes on about as slowly as one that grew on them, which
    // changes by 0.05 and 0.12.
    Substances later = grown;
    on_texels.run(gray_scott(spots.rates), int(100 / on_texels.time_step()), later);
    EXPECT_LT((second_of(later) - v).norm(), 0.2 * (v.array() - v.mean()).matrix().norm());
  }
}

TEST(PatternGrowth, StaysOnTheSpaceWhereWavesAreShortOrThereIsNoOtherSurface) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  const GrayScottPreset& spots = gray_scott_presets().front();
  for (const auto& [texels, surface] : {std::pair<double, const Surface*>{7, &model->surface}, {30, nullptr}}) {
    const double wave = texels * space.scale().texel_spacing;
    const PatternGrowth growth(space, surface, diffusivities(spots, wave), wave, 50);
    ASSERT_EQ(growth.stages().size(), 1U);
    const Substances grown = growth.grow(gray_scott(spots.rates), growth.seeds(4));
    const ReactionDiffusion process(space, diffusivities(spots, wave));
    Substances state = seeded_substances(places_of(space), wave, 4);
    process.run(gray_scott(spots.rates), int(std::ceil(50 / process.time_step())), state);
    EXPECT_EQ(grown, state);
  }
}

TEST(PatternGrowth, TakesAllOfAShortTimeOnTheSpace) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{128, 128}});
  const TexelSpace space(model->surface, model->atlas);
  const double wave = 40 * space.scale().texel_spacing;
  const auto stages_of = [&](double time) {
    return PatternGrowth(space, &model->surface, diffusivities(gray_scott_presets().front(), wave), wave, time);
  };
  const PatternGrowth brief = stages_of(10), longer = stages_of(1000);
  ASSERT_EQ(brief.stages().size(), 1U);
  EXPECT_NEAR(brief.stages()[0].steps * brief.stages()[0].process->time_step(), 10, 1);
  ASSERT_EQ(longer.stages().size(), 2U);
  EXPECT_NEAR(longer.stages()[0].steps * longer.stages()[0].process->time_step(), 1000 - 16, 1);
  EXPECT_NEAR(longer.stages()[1].steps * longer.stages()[1].process->time_step(), 16, 1);
  const PatternGrowth endless = stages_of(1e12);
  EXPECT_THROW(endless.grow(gray_scott({}), endless.seeds(0)), InvalidInput);
}

}  // namespace
}  // namespace mq
