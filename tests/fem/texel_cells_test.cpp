#include "mq/fem/texel_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fem/reference_integrals.h"
#include "mq/base/random.h"

namespace mq {
namespace {

using Polygon = std::vector<std::array<double, 2>>;

void expect_moments(const Polygon& polygon, const std::array<double, 9>& exact) {
  const std::array<double, 9> moments = bernstein_moments(polygon);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(moments[k] / exact[k], 1, 1e-14) << k;
}

/// Fractions by Green's theorem in exact arithmetic.
TEST(BernsteinMoments, AreTheFractionsTheyShouldBe) {
  expect_moments({{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                 {1.0 / 9, 1.0 / 18, 1.0 / 9, 1.0 / 18, 1.0 / 36, 1.0 / 18, 1.0 / 9, 1.0 / 18, 1.0 / 9});
  expect_moments({{0, 0}, {1, 0}, {0, 1}},
                 {19.0 / 180, 2.0 / 45, 1.0 / 18, 2.0 / 45, 1.0 / 72, 1.0 / 90, 1.0 / 18, 1.0 / 90,
                  1.0 / 180});
  expect_moments({{0.25, 0}, {1, 0}, {1, 0.5}, {0, 0.75}},
                 {45509.0 / 737280, 35263.0 / 737280, 14857.0 / 147456, 21991.0 / 737280,
                  13277.0 / 737280, 4835.0 / 147456, 21149.0 / 737280, 9943.0 / 737280,
                  2977.0 / 147456});
  expect_moments({{0.125, 0.25}, {0.75, 0}, {1, 0.5}, {0.5, 1}, {0, 0.625}},
                 {256973.0 / 5242880, 190251.0 / 5242880, 63673.0 / 1048576, 194139.0 / 5242880,
                  121677.0 / 5242880, 188747.0 / 5242880, 275389.0 / 5242880, 35327.0 / 1048576,
                  235021.0 / 5242880});
}

/// A sliver along the diagonal, 2⁻³⁰ wide: each moment to its own last digits.
TEST(BernsteinMoments, KeepTheirDigitsInSlivers) {
  const double w = 0x1p-30, d = 222829207071368449481842360320.0;
  expect_moments({{0, 0}, {1, 1}, {1 - w, 1}},
                 {6917529030862307329.0 / d, 3458764513820540927.0 / d, 3458764510599315457.0 / d,
                  3458764517041766402.0 / d, 3458764515431153662.0 / d, 6917529021198630914.0 / d,
                  3458764520262991882.0 / d, 6917529040525983734.0 / d, 34587645105993154570.0 / d});
}

TEST(BernsteinMoments, AreThoseOfARuleOfHigherDegreeOnAnyPolygon) {
  const Random random(4);
  for (std::uint64_t k = 0; k < 300; ++k) {
    fixtures::RealPolygon cell = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int line = 0; line < 3; ++line) {
      const double angle = random.uniform(6 * k + line, 0, 6.28);
      const double a = std::cos(angle), b = std::sin(angle);
      cell = fixtures::cut_by_line(cell, a, b, 0.5 * (a + b) + random.uniform(6 * k + 3 + line, 0, 0.4));
    }
    Polygon polygon;
    for (auto& p : cell) {
      polygon.push_back({double(p[0]), double(p[1])});
      p = {polygon.back()[0], polygon.back()[1]};
    }
    std::array<fixtures::Real, 9> exact{};
    fixtures::for_each_gauss_point(cell, [&](auto x, auto y, auto weight) {
      const decltype(x) bx[3] = {(1 - x) * (1 - x), (1 - x) * x, x * x};
      const decltype(x) by[3] = {(1 - y) * (1 - y), (1 - y) * y, y * y};
      for (int q = 0; q < 3; ++q)
        for (int p = 0; p < 3; ++p) exact[p + 3 * q] += weight * bx[p] * by[q];
    });
    const std::array<double, 9> moments = bernstein_moments(polygon);
    for (int n = 0; n < 9; ++n) EXPECT_NEAR(moments[n] / double(exact[n]), 1, 1e-13) << k;
  }
}

TEST(CellIntegrals, OfAWholeCellAreTheTextbooks) {
  const TexelMetric metric{0.25, 1.7, 0.4, 1.16 / 1.7};
  const double a = metric.a, b = metric.b, c = metric.c;
  CellIntegrals cell;
  add_integrals(whole_moments(), metric, cell);
  const std::array<double, 6> expected = {-a / 3 + c / 6,         a / 6 - c / 3, -a / 6 - c / 6 - b / 2,
                                          -a / 6 - c / 6 + b / 2, a / 6 - c / 3, -a / 3 + c / 6};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(cell.stiffness[k], expected[k], 1e-15) << k;
  for (int q = 0; q < 3; ++q)
    for (int p = 0; p < 3; ++p)
      EXPECT_NEAR(cell.mass[p + 3 * q], 0.25 * (p == 1 ? 1.0 / 6 : 1.0 / 3) * (q == 1 ? 1.0 / 6 : 1.0 / 3),
                  1e-16);
}

}  // namespace
}  // namespace mq
