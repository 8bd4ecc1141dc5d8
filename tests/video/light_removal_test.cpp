#include "mq/video/light_removal.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/fem/vertex_space.h"
#include "mq/video/flicker.h"

namespace mq {
namespace {

using test::random_signal;

std::shared_ptr<const SignalSpace> torus() {
  return std::make_shared<VertexSpace>(make_surface(fixtures::torus(24, 16)));
}

std::vector<Signal> without_lighting(const std::vector<Signal>& film, const SignalSpace& space,
                                     const LightRemovalOptions& options, int added_at = -1) {
  std::vector<Signal> result;
  const std::shared_ptr<const SignalSpace> shared(&space, [](const SignalSpace*) {});
  const TemporalReport report = remove_lighting(
      int(film.size()),
      [&](int f, const Progress&) {
        TimeLinks links = identical_links(space.size());
        if (f == 0) links = {};
        if (f == added_at) {
          links.entries.clear();
          links.starts.assign(space.size() + 1, 0);
        }
        return TemporalFrame{shared, nullptr, film[f], links};
      },
      [&](int f, const TemporalFrame&, Signal phi) {
        EXPECT_EQ(f, int(result.size()));
        result.push_back(std::move(phi));
      },
      options);
  EXPECT_LE(report.held, 2 * options.radius + 1);
  EXPECT_EQ(result.size(), film.size());
  return result;
}

TEST(WindowWeight, IsTheCubicBSpline) {
  EXPECT_DOUBLE_EQ(window_weight(0, 10), 2.0 / 3);
  EXPECT_DOUBLE_EQ(window_weight(11, 21), 1.0 / 6);
  EXPECT_EQ(window_weight(11, 10), 0);
  EXPECT_GT(window_weight(10, 10), 0);
  double sum = 0;  // a partition of unity at every multiple of the knots' distance
  for (int k = -10; k <= 10; ++k) sum += window_weight(k, 10);
  EXPECT_NEAR(sum, 11.0 / 2, 1e-3);
}

TEST(LightRemoval, GivesBackWhatDoesNotChange) {
  const auto space = torus();
  const std::vector<Signal> film(25, random_signal(space->size(), 3));
  for (const Signal& phi : without_lighting(film, *space, {.weight = 0.1}))
    EXPECT_LE((phi - film[0]).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(LightRemoval, TakesTheWeightedMeanWithoutGradients) {
  const auto space = torus();
  std::vector<Signal> film;
  for (int f = 0; f < 12; ++f) film.push_back(random_signal(space->size(), 2, f + 1));
  const std::vector<Signal> phi = without_lighting(film, *space, {.weight = 0, .radius = 3}, 5);
  for (int f = 0; f < 12; ++f) {
    Signal mean = Signal::Zero(space->size(), 2);
    double sum = 0;
    for (int g = f - 3; g <= f + 3; ++g) {
      if (g < 0 || g > 11 || (g < 5) != (f < 5)) continue;  // all points are born in frame 5
      mean += window_weight(g - f, 3) * film[g];
      sum += window_weight(g - f, 3);
    }
    EXPECT_LE((phi[f] - mean / sum).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(LightRemoval, TakesTheMeanForLowFrequenciesAndTheFrameForHighOnes) {
  const auto space = torus();
  const SparseMatrix S = space->stiffness();
  const Vector m = space->lumped_mass();
  std::vector<Signal> film;
  for (int f = 0; f < 9; ++f) film.push_back(random_signal(space->size(), 1, f + 1));
  const double w = 0.05;
  const std::vector<Signal> mean = without_lighting(film, *space, {.weight = 0, .radius = 4});
  const std::vector<Signal> phi = without_lighting(film, *space, {.weight = w, .radius = 4});
  for (int f = 0; f < 9; ++f) {
    Signal error = m.asDiagonal() * (phi[f] - mean[f]);
    error += w * (S * (phi[f] - film[f]));
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 1e-13);
  }
}

/// With A = 1 + w m⁻¹S the mean's part 3A⁻² − 2A⁻³ is what solves A³·δ = (1 + 3w m⁻¹S)·(ψ̄ − ψ).
TEST(LightRemoval, PartsWavesSteeply) {
  const auto space = torus();
  const SparseMatrix S = space->stiffness();
  const Vector m = space->lumped_mass();
  std::vector<Signal> film;
  for (int f = 0; f < 7; ++f) film.push_back(random_signal(space->size(), 2, f + 1));
  const double w = 0.05;
  const auto times_A = [&](const Signal& x, double weight) {
    return Signal(x + weight * (m.cwiseInverse().asDiagonal() * (S * x)));
  };
  const std::vector<Signal> mean = without_lighting(film, *space, {.weight = 0, .radius = 4});
  const std::vector<Signal> phi = without_lighting(
      film, *space, {.weight = w, .radius = 4, .crossover = LightRemovalOptions::Crossover::steep});
  for (int f = 0; f < 7; ++f) {
    const Signal change = times_A(times_A(times_A(phi[f] - film[f], w), w), w);
    const Signal wanted = times_A(mean[f] - film[f], 3 * w);
    EXPECT_LE((change - wanted).norm(), 1e-11 * wanted.norm());
  }
}

TEST(LightRemoval, RefusesWeightsThatMeanNothing) {
  const auto space = torus();
  const std::vector<Signal> film(2, random_signal(space->size(), 1));
  EXPECT_THROW(without_lighting(film, *space, {.weight = -1}), InvalidInput);
  EXPECT_THROW(without_lighting(film, *space, {.weight = 0, .radius = -1}), InvalidInput);
}

TEST(Flicker, IsTheDeviationOfNoiseThatIsWhiteInTime) {
  const Random random(5);
  std::uint64_t draw = 0;
  const int n = 500;
  const Signal pattern = random_signal(n, 3);
  FlickerMeter meter;
  std::vector<char> counted(n, 1);
  for (int t = 400; t < n; ++t) counted[t] = 0;
  for (int f = 0; f < 40; ++f) {
    Signal signal = pattern;
    for (int t = 0; t < n; ++t)
      for (int c = 0; c < 3; ++c)
        signal(t, c) += t < 400 ? random.uniform(draw++, -0.3, 0.3) : random.uniform(draw++) * 100;
    meter.add(f > 0 ? identical_links(n) : TimeLinks(), counted, signal);
  }
  const Flicker flicker = meter.finish();
  EXPECT_EQ(flicker.values, 400 * 40);
  EXPECT_NEAR(flicker.deviation, 0.3 / std::sqrt(3), 0.002);
  EXPECT_NEAR(flicker.step, 0.3 / std::sqrt(3), 0.002);
}

TEST(Flicker, LooksAtEachLifeAlone) {
  FlickerMeter meter;
  TimeLinks nothing;
  nothing.starts = {0, 0};
  const std::vector<char> counted = {1};
  meter.add({}, counted, Signal::Constant(1, 1, 3.0));
  meter.add(identical_links(1), counted, Signal::Constant(1, 1, 3.0));
  meter.add(nothing, counted, Signal::Constant(1, 1, 50.0));
  meter.add(identical_links(1), counted, Signal::Constant(1, 1, 52.0));
  const Flicker flicker = meter.finish();
  EXPECT_DOUBLE_EQ(flicker.deviation, std::sqrt(2.0 / 2));  // (1 + 1) by two lives' one each
  EXPECT_DOUBLE_EQ(flicker.step, std::sqrt(0.5 * 4 / 2));
}

}  // namespace
}  // namespace mq
