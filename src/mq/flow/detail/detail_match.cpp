#include "mq/flow/detail/detail_match.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/flow/detail/field_claims.h"
#include "mq/image/gaussian.h"

namespace mq {
namespace {

/// Deviations of Gaussians, in √area: detail is finer than the first and compared over the second.
constexpr double detail_length = 0.01, compared_length = 0.012;

/// In deviations of the signals, whose variance is 1.
constexpr float least_detail = 0.05F;

/// A tenth of all pixels is flat: what detail they have may be noise, and detail is so many times as much variance.
constexpr double flat_part = 0.1;
constexpr float times_flat = 3;

/// Correlation of what is alike.
constexpr float least_correlation = 0.5F;

/// Of all pixels, that must have detail to tell by.
constexpr double least_told = 0.01;

Image<float> smoothed_by(const Image<float>& image, double length) {
  const double deviation = length * std::sqrt(double(image.pixel_count()));
  return smoothed(image, deviation * deviation / 2);
}

/// What is finer than `detail_length` along one way.
Image<float> detail_along(const Image<float>& signal, const Image<float>& way) {
  Image<float> detail = displaced(signal, way);
  const Image<float> coarse = smoothed_by(detail, detail_length);
  parallel_for(std::ssize(detail.values()), [&](std::int64_t i) {
    detail.values()[std::size_t(i)] -= coarse.values()[std::size_t(i)];
  });
  return detail;
}

/// Means around each pixel of the channels' mean a², b² and a·b.
Image<float> mean_products(const Image<float>& first, const Image<float>& second) {
  Image<float> products(first.width(), first.height(), 3);
  parallel_for(
      first.height(),
      [&](std::int64_t row) {
        for (int x = 0; x < first.width(); ++x) {
          const std::span<const float> a = first.pixel(x, int(row)), b = second.pixel(x, int(row));
          const std::span<float> to = products.pixel(x, int(row));
          for (std::size_t c = 0; c < a.size(); ++c) to[0] += a[c] * a[c], to[1] += b[c] * b[c], to[2] += a[c] * b[c];
          for (float& value : to) value /= float(a.size());
        }
      },
      row_block);
  return smoothed_by(products, compared_length);
}

/// The value that such a part of all does not surpass.
float quantile(std::vector<float> values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(double(values.size()) * part);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// a² + b² of the flattest pixels that are seen.
float flat_variance(const Image<float>& products, const std::vector<char>& seen) {
  std::vector<float> sums;
  for (std::size_t p = 0; p < seen.size(); ++p)
    if (seen[p]) sums.push_back(products.values()[3 * p] + products.values()[3 * p + 1]);
  return sums.empty() ? 0 : quantile(std::move(sums), flat_part);
}

/// ∂X₁/∂x, ∂X₁/∂y, ∂X₂/∂x, ∂X₂/∂y of all pixels, one after another.
std::array<std::vector<float>, 4> slopes_of(const Image<float>& X) {
  std::array<std::vector<float>, 4> slopes;
  for (int y = 0; y < X.height(); ++y)
    for (int x = 0; x < X.width(); ++x)
      for (int c = 0; c < 2; ++c) {
        const Slope here = slope(X, x, y, c);
        slopes[std::size_t(2 * c)].push_back(here.x);
        slopes[std::size_t(2 * c + 1)].push_back(here.y);
      }
  return slopes;
}

double bend_of(const Image<float>& X) {
  const std::array<std::vector<float>, 4> slopes = slopes_of(smoothed_by(X, detail_length));
  std::vector<float> squares(slopes[0].size());
  for (const std::vector<float>& of_one : slopes) {
    const float usual = quantile(of_one, 0.5);
    for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += (of_one[i] - usual) * (of_one[i] - usual);
  }
  return std::sqrt(double(quantile(std::move(squares), 0.5)));
}

}  // namespace

DetailMatch detail_match(const SignalPair& signals, const Image<float>& X, const std::vector<char>& seen) {
  DetailMatch match;
  match.bend = bend_of(X);
  const FieldWays ways = ways_along(X, 0.5, FlowPath::straight);
  const Image<float> products =
      mean_products(detail_along(signals.source, ways.back), detail_along(signals.target, ways.forth));
  const float least = std::max(2 * least_detail * least_detail, times_flat * flat_variance(products, seen));
  std::int64_t told = 0, alike = 0;
  for (std::size_t p = 0; p < seen.size(); ++p) {
    const float *of = &products.values()[3 * p], a = of[0], b = of[1], both = of[2];
    if (!seen[p] || a + b < least) continue;
    ++told;
    if (both > least_correlation * std::sqrt(a * b)) ++alike;
  }
  if (double(told) > least_told * double(seen.size())) match.alike = double(alike) / double(told);
  return match;
}

}  // namespace mq
