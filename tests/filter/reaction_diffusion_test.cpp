// Reaction and diffusion: what stays, what is conserved, how fast it spreads, what grows.

#include "mq/filter/reaction_diffusion.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "filter/geodesic_squares.h"
#include "mq/fem/vertex_space.h"

namespace mq {
namespace {

using fixtures::places_of;
using fixtures::whole_square;

using std::numbers::pi;

void no_reaction(std::span<const float>, std::span<float> rate) {
  std::fill(rate.begin(), rate.end(), 0.0F);
}

TEST(ReactionDiffusion, LeavesAnEquilibriumAsItIs) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const ReactionDiffusion process(space, {1e-3, 5e-4});
    Substances state;
    for (int i = 0; i < space.size(); ++i) state.push_back(1), state.push_back(0);
    const Substances before = state;
    process.run(gray_scott({0.03, 0.06}), 20, state);  // u = 1, v = 0 is one
    EXPECT_EQ(state, before) << cut.name;
  }
}

/// cos(πx) decays by exp(−D π² t).
TEST(ReactionDiffusion, SpreadsAsFastAsItsDiffusivitySays) {
  for (const fixtures::CutOptions& options :
       {whole_square(), fixtures::turned(fixtures::odd_angle)}) {
    const TextureSize size{96, 96};
    const auto model = fixtures::textured(fixtures::cut_square(options), {size});
    const TexelSpace space(model->surface, model->atlas);
    const double h = space.scale().texel_spacing, D = 0.2 * h * h;
    const ReactionDiffusion process(space, {D, D / 2});
    const auto x = fixtures::texels_on_square(options, size, space.texels());
    Substances state;
    for (int i = 0; i < space.size(); ++i) {
      state.push_back(float(std::cos(pi * x[i].x())));
      state.push_back(float(std::cos(2 * pi * x[i].y())));
    }
    const Substances before = state;
    const double time = 0.5 / (pi * pi * D);
    process.run(no_reaction, int(std::lround(time / process.time_step())), state);
    double u = 0, v = 0, uu = 0, vv = 0;
    for (int i = 0; i < space.size(); ++i) {
      u += state[2 * i] * before[2 * i], uu += before[2 * i] * before[2 * i];
      v += state[2 * i + 1] * before[2 * i + 1], vv += before[2 * i + 1] * before[2 * i + 1];
    }
    EXPECT_NEAR(u / uu, std::exp(-0.5), 0.01);
    EXPECT_NEAR(v / vv, std::exp(-1.0), 0.01);
  }
}

TEST(ReactionDiffusion, StaysFiniteWhereTexelsAreSmall) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const ReactionDiffusion process(space, {0.01, 0.005});
    Substances state = seeded_substances(places_of(space), 0.1, 3);
    process.run(gray_scott({0.03, 0.06}), 300, state);
    for (const float value : state) {
      EXPECT_TRUE(std::isfinite(value));
      EXPECT_LE(std::abs(value), 2) << cut.name;
    }
    EXPECT_LE(process.slowed(), 0.1 + 1.0 / space.size()) << cut.name;
  }
}

TEST(ReactionDiffusion, GrowsPatternsOfTheWaveLengthAskedFor) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{112, 112}});
  const TexelSpace space(model->surface, model->atlas);
  const SparseMatrix M = space.mass(), S = space.stiffness();
  const double wanted = 14 * space.scale().texel_spacing;
  for (const GrayScottPreset& preset : gray_scott_presets()) {
    const ReactionDiffusion process(space, diffusivities(preset, wanted));
    Substances state = seeded_substances(places_of(space), wanted, 1);
    process.run(gray_scott(preset.rates), int(3000 / process.time_step()), state);
    Vector v(space.size());
    for (int i = 0; i < space.size(); ++i) v[i] = state[2 * i + 1];
    v.array() -= (M * v).sum() / M.sum();
    EXPECT_GE(v.maxCoeff() - v.minCoeff(), 0.2) << preset.name;
    EXPECT_NEAR(2 * pi * std::sqrt(v.dot(M * v) / v.dot(S * v)), wanted, 0.08 * wanted)
        << preset.name;
  }
}

TEST(ReactionDiffusion, HasTheSameBitsForAnyNumberOfThreads) {
  const VertexSpace space(make_surface(fixtures::torus(80, 50)));
  std::vector<Substances> results;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    const ReactionDiffusion process(space, {1e-3, 5e-4});
    Substances state(std::size_t(2 * space.size()), 0.5F);
    for (std::size_t k = 0; k < state.size(); k += 7) state[k] = 0.9F;
    process.run(gray_scott({}), 50, state);
    results.push_back(state);
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

/// Where spots are much larger than the surface, too.
TEST(ReactionDiffusion, HasSeedsWhateverTheirNumber) {
  const VertexSpace space(make_surface(fixtures::torus(40, 30)));
  for (const double spacing : {0.3, 3.0, 1e4})
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const Substances state = seeded_substances(space.positions(), spacing, seed);
      int seeds = 0;
      for (std::size_t i = 1; i < state.size(); i += 2) seeds += state[i] > 0;
      EXPECT_GE(seeds, space.size() / 50) << spacing << ", " << seed;
    }
}

TEST(ReactionDiffusion, RefusesWhatHasNoMeaning) {
  const VertexSpace space(make_surface(fixtures::torus(8, 6)));
  EXPECT_THROW(ReactionDiffusion(space, {-1, 1}), InvalidInput);
  EXPECT_THROW(ReactionDiffusion(space, {1, 1}, 0), InvalidInput);
  Substances few(3);
  EXPECT_THROW(ReactionDiffusion(space, {1, 1}).run(gray_scott({}), 1, few), InvalidInput);
}

}  // namespace
}  // namespace mq
