// Seams at all distances from texel lines: what depends on them, and what does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/cut_squares.h"
#include "fem/scaled_spectrum.h"
#include "mq/base/random.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::CutOptions;
using fixtures::sample;
using fixtures::scaled_spectrum;
using fixtures::value_at;

/// Seams so many texels off the texel lines they run along, or with corners so far off texel
/// centres, charts turned.
Cut seams_beside_lines(double offset, double angle, TextureSize size = {24, 24}) {
  CutOptions options;
  options.jitter = 0;
  options.cells = 4;
  options.scale = 0.75;
  if (angle != 0) options.scale = 0.5;
  options.angle = [angle](int chart) { return chart * angle; };
  options.shift = [=](int chart) {
    return Vector2((0.5 + offset * (chart + 1)) / size.width, (0.5 - offset) / size.height);
  };
  return fixtures::cut("", options, size);
}

constexpr std::array<double, 8> offsets = {0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 0.0};

/// Of the mass, and of the system whose weight is 4 to 6 texels squared. No seam's place shows in
/// it.
TEST(TexelSpace, StaysWellConditionedHoweverNearASeamIsToTexels) {
  for (const double angle : {0.0, std::acos(-1.0) / 2, 1.1})
    for (const TextureSize size : {TextureSize{24, 24}, TextureSize{24, 40}})
      for (const double offset : offsets) {
        const Cut cut = seams_beside_lines(offset, angle, size);
        const TexelSpace space(cut.model->surface, cut.model->atlas);
        const auto [largest, condition] = scaled_spectrum(space.regularised_system(1, 1e-2));
        const auto [mass_largest, mass_condition] = scaled_spectrum(space.regularised_system(1, 0));
        EXPECT_LT(largest, 5) << angle << ' ' << size.height << ' ' << offset;
        EXPECT_LT(condition, 60) << angle << ' ' << size.height << ' ' << offset;
        EXPECT_LT(mass_largest, 5) << angle << ' ' << size.height << ' ' << offset;
        EXPECT_LT(mass_condition, 120) << angle << ' ' << size.height << ' ' << offset;
      }
}

/// A smoothed function of the square, at places of it.
std::vector<double> smoothed_beside_lines(double offset, double angle, int size) {
  const Cut cut = seams_beside_lines(offset, angle, {size, size});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = sample(cut, space, [](const Vector2& p) {
    return std::sin(9 * p.x() + 2 * p.y()) * std::cos(8 * p.y());
  });
  const Signal phi = DirectSolver(space.system(1, 1e-3)).solve(space.mass() * psi);
  const Random random(17);
  std::vector<double> values;
  for (std::uint64_t k = 0; k < 3200; ++k)
    values.push_back(value_at(space, phi, int(k % cut.model->surface.triangle_count()),
                              fixtures::random_point(random, k)));
  return values;
}

double change_by_offset(double offset, double angle, int size = 24) {
  const std::vector<double> at_zero = smoothed_beside_lines(0, angle, size),
                            near = smoothed_beside_lines(offset, angle, size);
  double worst = 0;
  for (std::size_t k = 0; k < near.size(); ++k)
    worst = std::max(worst, std::abs(near[k] - at_zero[k]));
  return worst;
}

/// Where texels of both sides meet at seams, what is filtered moves with the seams and no faster.
TEST(TexelSpace, VariesContinuouslyWithTheOffsetOfASeam) {
  for (const double angle : {0.0, std::acos(-1.0) / 2})
    for (const double offset : offsets)
      EXPECT_LT(change_by_offset(offset, angle), 1.2 * offset + 1e-10) << angle << ' ' << offset;
}

/// Where a seam crosses a texel line the texels beyond it become unknowns, however little they
/// cover: seam values, means of both sides, gain a freedom. It is of use as far as the sides
/// disagree, so the result jumps, by less the finer the texture (1.4e-3 with 24² texels, 1.8e-4
/// with 96²), and not at all where texels of both sides meet.
TEST(TexelSpace, JumpsALittleWhereASeamCrossesATexelLine) {
  const double coarse = change_by_offset(1e-8, 1.1, 24), fine = change_by_offset(1e-8, 1.1, 96);
  EXPECT_LT(coarse, 2e-3);
  EXPECT_GT(coarse / fine, 6) << coarse << ' ' << fine;
  for (const double offset : offsets)
    EXPECT_LT(change_by_offset(offset, 1.1), offset + 1.1 * coarse) << offset;
}

}  // namespace
}  // namespace mq
