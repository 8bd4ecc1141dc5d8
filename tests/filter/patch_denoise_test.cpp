// Denoising by patches: what stays, what goes, and that it does not matter how a surface is cut.

#include "mq/filter/patch_denoise.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/image_space.h"
#include "mq/filter/chart_windows.h"
#include "mq/filter/detail/even_noise.h"
#include "mq/filter/kernels/similar_patches.h"
#include "mq/filter/noise_curve.h"
#include "mq/filter/noise_level.h"

namespace mq {
namespace {

constexpr double deviation = 0.05;

double gaussian(const Random& random, std::uint64_t k) {
  return std::sqrt(-2 * std::log(1 - random.uniform(2 * k))) *
         std::cos(2 * std::numbers::pi * random.uniform(2 * k + 1));
}

/// Rings around a corner of the unit square, and a disc with a sharp rim.
double rings(const Vector2& x) {
  const double wave = 0.5 + 0.2 * std::sin(40 * x.norm());
  return (x - Vector2(0.55, 0.45)).norm() < 0.2 ? 0.9 : wave;
}

/// A square in charts, with a picture of two channels and noise on it.
struct Noisy {
  Noisy(const fixtures::CutOptions& options, int side, double noise = deviation)
      : model(fixtures::textured(fixtures::cut_square(options), {{side, side}})),
        space(model->surface, model->atlas),
        x(fixtures::texels_on_square(options, {side, side}, space.texels())),
        truth(space.size(), 2),
        psi(space.size(), 2) {
    const Random random(5);
    for (int i = 0; i < space.size(); ++i) {
      truth.row(i) << rings(x[std::size_t(i)]), 1 - rings(x[std::size_t(i)]);
      for (int c = 0; c < 2; ++c) psi(i, c) = truth(i, c) + noise * gaussian(random, 2 * i + c);
    }
  }

  PatchDenoised denoised() const { return denoise_by_patches(model->surface, model->atlas, space, psi); }

  /// Root mean square of the error, but for the border of the square.
  double error(const Signal& signal) const {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < space.size(); ++i) {
      const Vector2& p = x[std::size_t(i)];
      if (p.minCoeff() < 0.03 || p.maxCoeff() > 0.97) continue;
      sum += (signal.row(i) - truth.row(i)).squaredNorm() / 2;
      ++count;
    }
    return std::sqrt(sum / count);
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  std::vector<Vector2> x;
  Signal truth, psi;
};

const fixtures::CutOptions whole{.parts = 1, .scale = 0.9};

/// Four charts, each turned, of about the same texels as a whole square of 0.54 of the side.
fixtures::CutOptions four_charts() { return fixtures::turned(fixtures::odd_angle); }

TEST(DenoiseByPatches, TakesMostOfTheNoiseOff) {
  const Noisy noisy(whole, 192);
  const PatchDenoised found = noisy.denoised();
  for (const double noise : found.noise) EXPECT_NEAR(noise, deviation, 0.05 * deviation);
  EXPECT_LT(noisy.error(found.signal), 0.25 * deviation);
}

/// Half of the change leaves half of the noise, and of what is left of all of it.
TEST(DenoiseByPatches, TakesOffAsMuchAsItIsAskedTo) {
  const Noisy noisy(whole, 128);
  const auto left = [&](double strength) {
    return noisy.error(
        denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, noisy.psi, {.strength = strength})
            .signal);
  };
  EXPECT_GT(left(0.5), 0.5 * deviation);
  EXPECT_LT(left(0.5), 0.6 * deviation);
  EXPECT_TRUE(denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, noisy.psi, {.strength = 1}).signal ==
              noisy.denoised().signal);
  EXPECT_THROW(left(0), InvalidInput);
}

TEST(DenoiseByPatches, MeasuresNoiseWhateverItsStrength) {
  for (const double noise : {0.01, 0.1, 3.0}) {
    const Noisy noisy(whole, 192, noise);
    const ChartWindows windows(noisy.model->surface, noisy.model->atlas, noisy.space);
    for (const double found : noise_levels(windows, noisy.psi)) EXPECT_NEAR(found, noise, 0.06 * noise);
  }
}

TEST(DenoiseByPatches, LeavesWhatIsConstantOrWithoutNoiseBitForBit) {
  const Noisy noisy(four_charts(), 128);
  const Signal constant = Signal::Constant(noisy.space.size(), 3, 0.3);
  EXPECT_EQ(denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, constant).signal, constant);
  Signal step = constant;
  for (int i = 0; i < noisy.space.size(); ++i)
    if (noisy.x[std::size_t(i)].x() < 0.3) step.row(i).setConstant(0.8);
  EXPECT_EQ(denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, step).signal, step);
}

TEST(DenoiseByPatches, ChangesASmoothPictureByNextToNothing) {
  const Noisy noisy(whole, 160);
  Signal smooth(noisy.space.size(), 1);
  for (int i = 0; i < noisy.space.size(); ++i) {
    const Vector2& p = noisy.x[std::size_t(i)];
    smooth(i, 0) = 0.5 + 0.3 * std::sin(9 * p.x() + 4 * p.y()) * std::cos(7 * p.y());
  }
  const Signal found = denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, smooth).signal;
  EXPECT_LT((found - smooth).cwiseAbs().maxCoeff(), 0.1 / 255);
}

/// Edges a million times stronger than the noise: single precision sees their patches differ in a few ways only.
TEST(DenoiseByPatches, TakesNoMoreOffThanNoiseIsWhateverThePatches) {
  constexpr int rows = most_patch_values;
  const Random random(11);
  std::uint64_t n = 0;
  for (const double strength : {1.0, 1e3, 1e5, 1e7, 1e12})
    for (int ways = 1; ways <= 4; ++ways)
      for (int round = 0; round < 8; ++round) {
        std::vector<float> patches(rows * most_patches, 0);
        for (int way = 0; way < ways; ++way) {
          std::vector<double> across(most_patches);
          for (double& value : across) value = strength * gaussian(random, n++);
          for (int r = 0; r < rows; ++r) {
            const double along = gaussian(random, n++);
            for (int k = 0; k < most_patches; ++k) patches[std::size_t(r * most_patches + k)] += float(along * across[std::size_t(k)]);
          }
        }
        const std::vector<float> before = patches;
        similar_patch_kernels().shrink(rows, most_patches, 1e-3F, before.data(), patches.data());
        for (std::size_t i = 0; i < patches.size(); ++i)
          ASSERT_LE(std::abs(patches[i] - before[i]), 6 + 1e-6 * std::abs(before[i])) << strength << " " << ways;
      }
}

TEST(DenoiseByPatches, LeavesAChannelWithoutNoiseAlone) {
  Noisy noisy(four_charts(), 160);
  noisy.psi.col(1).setConstant(1);  // as alpha is
  const PatchDenoised found = noisy.denoised();
  EXPECT_EQ(found.noise[1], 0);
  EXPECT_EQ(found.signal.col(1), noisy.psi.col(1));
  EXPECT_GT((found.signal.col(0) - noisy.psi.col(0)).norm(), 0);
}

TEST(DenoiseByPatches, KeepsTheMean) {
  const Noisy noisy(four_charts(), 160);
  const Vector mass = noisy.space.lumped_mass();
  const Eigen::RowVectorXd before = mass.transpose() * noisy.psi,
                           after = mass.transpose() * noisy.denoised().signal;
  EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 1e-9);
}

/// Rising from dark to bright over the square, without edges.
double ramp(const Vector2& x) { return 0.1 + 3 * x.x() * x.x(); }

/// A ramp and its noise by a function of brightness.
struct NoisyRamp : Noisy {
  template <class Deviation>
  NoisyRamp(const fixtures::CutOptions& options, int side, Deviation deviation_at) : Noisy(options, side) {
    const Random random(6);
    for (int i = 0; i < space.size(); ++i)
      for (int c = 0; c < 2; ++c) {
        truth(i, c) = ramp(x[std::size_t(i)]);
        psi(i, c) = truth(i, c) + deviation_at(truth(i, c)) * gaussian(random, std::uint64_t(2 * i + c));
      }
  }
};

/// Of counted photons: σ² ∝ v; and of rays that are averaged: σ ∝ v.
TEST(NoiseCurve, FindsHowNoiseGoesWithBrightness) {
  for (const double power : {0.0, 0.5, 1.0}) {
    const NoisyRamp noisy(whole, 320, [&](double v) { return 0.05 * std::pow(v, power); });
    const ChartWindows windows(noisy.model->surface, noisy.model->atlas, noisy.space);
    const NoiseCurve curve = noise_curve(windows, noisy.psi);
    ASSERT_FALSE(curve.is_empty());
    EXPECT_TRUE(curve.spectrum.empty());
    for (const double v : {0.2, 0.5, 1.0, 2.0, 3.0})
      EXPECT_NEAR(curve.at(v, 0) / (0.05 * std::pow(v, power)), 1, 0.15) << v << " to the " << power;
  }
}

TEST(NoiseCurve, IsEmptyOfTextureAndOfNothing) {
  const Noisy noisy(whole, 192);
  const ChartWindows windows(noisy.model->surface, noisy.model->atlas, noisy.space);
  EXPECT_TRUE(noise_curve(windows, noisy.truth).is_empty());
  EXPECT_TRUE(noise_curve(windows, Signal::Constant(noisy.space.size(), 1, 2)).is_empty());
}

TEST(DenoiseByPatches, TakesOffNoiseThatGoesWithBrightnessWhereverItIs) {
  const NoisyRamp noisy(whole, 320, [](double v) { return 0.1 * v; });
  const Signal found = noisy.denoised().signal;
  for (const auto& [from, to] : {std::pair(0.1, 0.5), std::pair(0.5, 1.5), std::pair(1.5, 3.0)}) {
    double before = 0, after = 0;
    for (int i = 0; i < noisy.space.size(); ++i) {
      if (noisy.truth(i, 0) < from || noisy.truth(i, 0) > to) continue;
      before += (noisy.psi.row(i) - noisy.truth.row(i)).squaredNorm();
      after += (found.row(i) - noisy.truth.row(i)).squaredNorm();
    }
    EXPECT_LT(after, 0.06 * before) << from << " to " << to;
  }
}

/// Texels far above all others go, and hardly any light of theirs stays.
TEST(DenoiseByPatches, TakesFirefliesOff) {
  NoisyRamp noisy(whole, 192, [](double v) { return 0.1 * v; });
  const Random random(8);
  std::vector<int> flies;
  for (int i = 0; i < noisy.space.size(); ++i)
    if (random.uniform(std::uint64_t(i)) < 0.002) flies.push_back(i), noisy.psi.row(i) *= 30;
  ASSERT_GT(flies.size(), 20U);
  const PatchDenoised found = noisy.denoised();
  EXPECT_GE(found.fireflies, int(0.8 * double(flies.size())));
  EXPECT_LE(found.fireflies, int(1.2 * double(flies.size())));
  EXPECT_LT(noisy.error(found.signal), 0.06);
}

/// The square with texels at the ends of all values: so large a part of those where `at` says so, bright ones and dark ones.
template <class At>
std::vector<int> strewn(Noisy& noisy, double bright, double dark, const At& at) {
  const Random random(8);
  std::vector<int> strays;
  for (int i = 0; i < noisy.space.size(); ++i) {
    const double drawn = random.uniform(std::uint64_t(i));
    if (drawn >= bright + dark || !at(noisy.x[std::size_t(i)])) continue;
    strays.push_back(i);
    noisy.psi.row(i).setConstant(drawn < bright ? 1 : 0);
  }
  return strays;
}

/// As salt-and-pepper noise has them, alone and with other noise, and in charts.
TEST(DenoiseByPatches, TakesStrayTexelsOff) {
  for (const double noise : {0.0, 0.02})
    for (const double share : {0.01, 0.05}) {
      Noisy noisy(whole, 192, noise);
      const std::size_t count = strewn(noisy, share / 2, share / 2, [](const Vector2&) { return true; }).size();
      const double before = noisy.error(noisy.psi);
      const PatchDenoised found = noisy.denoised();
      EXPECT_NEAR(found.strays, double(count), 0.1 * double(count)) << noise << ' ' << share;
      EXPECT_LT(noisy.error(found.signal), 0.4 * before) << noise << ' ' << share;
    }
}

/// Stars are bright alone, dots of print lie in places, and pictures of dots are of nothing else.
TEST(DenoiseByPatches, LeavesStarsAndPrintBitForBit) {
  const auto everywhere = [](const Vector2&) { return true; };
  const auto left = [](const Vector2& x) { return x.x() < 0.2; };
  for (const int picture : {0, 1, 2}) {
    Noisy noisy(whole, 192);
    noisy.psi.setConstant(0.5);
    if (picture == 0) strewn(noisy, 0.02, 0, everywhere);
    if (picture == 1) strewn(noisy, 0.03, 0.03, left);
    if (picture == 2) {
      for (int i = 0; i < noisy.space.size(); ++i)
        noisy.psi.row(i).setConstant(noisy.x[std::size_t(i)].x() < 0.5 ? 0 : 1);
      strewn(noisy, 0.04, 0.04, everywhere);
    }
    const PatchDenoised found = noisy.denoised();
    EXPECT_EQ(found.strays, 0) << picture;
    EXPECT_TRUE(found.signal == noisy.psi) << picture;
  }
}

/// A lit wall with a window 200 times as bright and a strip 100 times as dark, and noise of a fifth, as rays have it.
TEST(DenoiseByPatches, KeepsLightOfAnyRangeWithoutLeaks) {
  Noisy noisy(whole, 256);
  const Random random(12);
  for (int i = 0; i < noisy.space.size(); ++i) {
    const Vector2& p = noisy.x[std::size_t(i)];
    const double light = p.x() < 0.3 && p.y() > 0.5 ? 40 : p.x() < 0.4 ? 0.002 : 0.2 + 0.1 * std::sin(9 * p.y());
    for (int c = 0; c < 2; ++c) {
      noisy.truth(i, c) = light;
      noisy.psi(i, c) = light * std::max(0.05, 1 + 0.2 * gaussian(random, std::uint64_t(2 * i + c)));
    }
  }
  const Signal found = noisy.denoised().signal;
  EXPECT_GT(found.minCoeff(), 0);
  double dark = 0, squares = 0, means = 0;
  int count = 0;
  for (int i = 0; i < noisy.space.size(); ++i) {
    const double ratio = found(i, 0) / noisy.truth(i, 0);
    if (noisy.truth(i, 0) == 0.002) dark = std::max(dark, found(i, 0));
    means += ratio;
    squares += (ratio - 1) * (ratio - 1);
    ++count;
  }
  EXPECT_LT(dark, 0.004);
  EXPECT_NEAR(means / count, 1, 0.02);
  EXPECT_LT(std::sqrt(squares / count), 0.25 * 0.2);
}

/// On the scale where noise is even a + r v is 1: of what is linear in v, and of light that is not far below 0.
TEST(EvenNoise, IsOfLinesAndOfLightAlone) {
  const auto curve = [](std::initializer_list<double> deviations) {
    NoiseCurve result;
    result.deviation.resize(Eigen::Index(deviations.size()), 1);
    for (const double d : deviations) {
      result.deviation(Eigen::Index(result.brightness.size()), 0) = d;
      result.brightness.push_back(double(result.brightness.size()));
    }
    return std::vector<NoiseCurve>{result};
  };
  const double a = 0.1, r = 0.2;
  const std::vector<NoiseCurve> line = curve({a, a + r, a + 2 * r, a + 3 * r}), uneven = curve({0.1, 0.9, 0.2, 1.5});
  Signal light(4, 1), dark(4, 1);
  light << 0, 0.5, 1, 3;
  dark << 0, 0.5, 1, -0.6 * a / r;
  const std::optional<EvenNoise> even = EvenNoise::of(line, light);
  ASSERT_TRUE(even);
  const Signal z = even->there(light);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(z(i, 0), std::log((a + r * light(i, 0)) / a) / r, 1e-12);
  EXPECT_EQ(even->back(z, z, {1}, light), light);
  EXPECT_FALSE(EvenNoise::of(uneven, light));
  EXPECT_FALSE(EvenNoise::of(line, dark));
  EXPECT_FALSE(EvenNoise::of(curve({0.4, 0.3, 0.2, 0.1}), light));
}

/// Noise of a mean of neighbours, as a camera's: σ² of blocks of four is a multiple of what high frequencies say.
struct SmoothedNoise : Noisy {
  explicit SmoothedNoise(int side) : Noisy(whole, side, 0) {
    const Random random(9);
    const auto white = [&](int x, int y, int c) { return gaussian(random, std::uint64_t((y * 4096 + x) * 2 + c)); };
    for (int i = 0; i < space.size(); ++i)
      for (int c = 0; c < 2; ++c) {
        double sum = 0;
        for (int dy = -2; dy <= 2; ++dy)
          for (int dx = -2; dx <= 2; ++dx)
            sum += std::exp(-(dx * dx + dy * dy) / (2 * 0.8 * 0.8)) *
                   white(space.texels().places[std::size_t(i)].x + dx + 8, space.texels().places[std::size_t(i)].y + dy + 8, c);
        truth(i, c) = 0.5 + 0.3 * std::sin(5 * x[std::size_t(i)].x());
        psi(i, c) = truth(i, c) + deviation / 2.8 * sum;
      }
  }
};

TEST(DenoiseByPatches, TakesOffNoiseThatACameraHasSmoothed) {
  const SmoothedNoise noisy(256);
  const PatchDenoised found = noisy.denoised();
  EXPECT_GT(found.smoothed, 3);
  EXPECT_LT(noisy.error(found.signal), 0.5 * noisy.error(noisy.psi));
}

/// The covariance of smoothed noise is that of its values.
TEST(NoiseCurve, FindsTheCovarianceOfSmoothedNoise) {
  const SmoothedNoise noisy(320);
  const ChartWindows windows(noisy.model->surface, noisy.model->atlas, noisy.space);
  const NoiseCurve curve = noise_curve(windows, noisy.psi);
  ASSERT_FALSE(curve.spectrum.empty());
  const Eigen::MatrixXd C = curve.covariance(0, 3) * std::pow(curve.at(0, 0), 2);
  // Of two texels dx apart: Σ g(t) g(t + dx) over both axes.
  const auto correlation = [](int d) {
    double sum = 0;
    for (int t = -2; t + d <= 2; ++t)
      if (t >= -2) sum += std::exp(-(t * t + (t + d) * (t + d)) / (2 * 0.8 * 0.8));
    return sum;
  };
  const double unit = std::pow(deviation / 2.8, 2);
  for (const int d : {0, 1, 2})
    EXPECT_NEAR(C(0, d), unit * correlation(0) * correlation(d), 0.2 * unit * correlation(0) * correlation(0)) << d;
  EXPECT_NEAR((C - C.transpose()).norm(), 0, 1e-12);
}

/// In charts of a few patches each, what is like a patch lies beyond seams.
TEST(DenoiseByPatches, IsAsGoodInSmallChartsAsInOne) {
  fixtures::CutOptions one = whole;
  one.scale = 0.6;
  const Noisy small(fixtures::turned(fixtures::odd_angle, 12), 256), uncut(one, 256);
  const double in_small = small.error(small.denoised().signal),
               in_one = uncut.error(uncut.denoised().signal);
  EXPECT_LT(in_one, 0.35 * deviation);
  EXPECT_LT(in_small, 1.15 * in_one);
}

/// The same noise in turned charts and in one: what is left of it is the same in size, and far less than was there.
TEST(DenoiseByPatches, HardlyDependsOnHowTheSurfaceIsCut) {
  fixtures::CutOptions one = whole;
  one.scale = 0.6;
  const Noisy cut(four_charts(), 320), uncut(one, 320);
  const Signal of_cut = cut.denoised().signal, of_uncut = uncut.denoised().signal;
  EXPECT_NEAR(cut.error(of_cut) / uncut.error(of_uncut), 1, 0.15);
  double sum = 0;
  int count = 0;
  for (int t = 0; t < cut.model->surface.triangle_count(); ++t) {
    const Vector3 middle = Vector3::Constant(1.0 / 3);
    const double a = fixtures::value_at(cut.space, of_cut, t, middle),
                 b = fixtures::value_at(uncut.space, of_uncut, t, middle);
    sum += (a - b) * (a - b);
    ++count;
  }
  EXPECT_LT(std::sqrt(sum / count), 0.6 * deviation);
}

TEST(DenoiseByPatches, GivesTheSameBitsForAnyNumberOfThreads) {
  const Noisy noisy(four_charts(), 160);
  std::vector<Signal> found;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    found.push_back(noisy.denoised().signal);
  }
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
}

/// Where windows look beyond a cut they find what lies there.
TEST(ChartWindows, GoOnOverSeams) {
  for (const auto& options : {four_charts(), fixtures::turned(fixtures::quarter_turn)}) {
    const Noisy noisy(options, 160);
    const double texel = noisy.space.scale().texel_spacing;
    const ChartWindows windows(noisy.model->surface, noisy.model->atlas, noisy.space);
    int beyond = 0;
    for (int w = 0; w < windows.count(); ++w) {
      const ChartWindow window = windows.window(w, 8);
      for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.width; ++x) {
          const std::size_t i = std::size_t(y * window.width + x);
          if (window.own[i] || window.unknowns[i] < 0) continue;
          // Beside it lie texels that are beside it on the square, too.
          for (const std::size_t j : {i - 1, i + 1, i - std::size_t(window.width), i + std::size_t(window.width)}) {
            if (j >= window.unknowns.size() || window.unknowns[j] < 0) continue;
            if ((j == i - 1 && x == 0) || (j == i + 1 && x + 1 == window.width)) continue;
            const Vector2 way = noisy.x[std::size_t(window.unknowns[i])] - noisy.x[std::size_t(window.unknowns[j])];
            beyond += way.norm() < 2.5 * texel ? 1 : -20;
          }
        }
    }
    EXPECT_GT(beyond, 1000);
  }
}

TEST(DenoiseByPatches, RefusesWhatDoesNotFit) {
  const Noisy noisy(whole, 32);
  EXPECT_THROW(denoise_by_patches(noisy.model->surface, noisy.model->atlas, noisy.space, Signal::Zero(3, 1)),
               InvalidInput);
}

}  // namespace
}  // namespace mq
