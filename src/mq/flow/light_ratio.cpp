#include "mq/flow/light_ratio.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/flow/detail/field_claims.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"
#include "mq/image/gaussian.h"

namespace mq {
namespace {

/// Over which means are taken, in √area, and what is added to them, in the mean of both images.
constexpr double width_of_means = 0.08, least_part = 0.01;

/// Of the largest value of an image, from where on it may be cut off.
constexpr float cut_off = 0.97F;

float largest(const Image<float>& image) {
  return image.empty() ? 0 : std::ranges::max(image.values());
}

/// The image where `told`, value by value, smoothed.
Image<float> means(Image<float> image, const std::vector<char>& told) {
  for (std::size_t i = 0; i < told.size(); ++i)
    if (!told[i]) image.values()[i] = 0;
  const double deviation = width_of_means * std::sqrt(double(image.pixel_count()));
  return smoothed(image, deviation * deviation / 2);
}

/// The image with each value times what `factor` makes of its logarithm.
template <class Factor>
Image<float> lit(const Image<float>& image, const Image<float>& logarithm, const Factor& factor) {
  Image<float> result = image;
  parallel_for(std::ssize(result.values()), [&](std::int64_t i) {
    result.values()[std::size_t(i)] *= factor(logarithm.values()[std::size_t(i)]);
  });
  return result;
}

}  // namespace

LightRatio light_ratio(const Image<float>& source, const Image<float>& target, const Image<float>& X) {
  const auto [back, forth] = ways_along(X, 0.5, FlowPath::straight);
  Image<float> first = displaced(source, back), second = displaced(target, forth);
  const float cut_first = cut_off * largest(source), cut_second = cut_off * largest(target);
  std::vector<char> told(first.values().size());
  for (int y = 0; y < X.height(); ++y)
    for (int x = 0; x < X.width(); ++x)
      for (int c = 0; c < first.channels(); ++c)
        told[std::size_t((y * X.width() + x) * first.channels() + c)] =
            lands_inside(back, x, y) && lands_inside(forth, x, y) && first(x, y, c) < cut_first &&
            second(x, y, c) < cut_second;
  first = means(std::move(first), told);
  second = means(std::move(second), told);
  const float added = float(least_part * (mean(source) + mean(target)) / 2);
  LightRatio ratio;
  if (!(added > 0)) {
    ratio.of_source = ratio.of_target = Image<float>(source.width(), source.height(), source.channels());
    return ratio;
  }
  Image<float> logarithm = first;
  parallel_for(std::ssize(logarithm.values()), [&](std::int64_t i) {
    float& value = logarithm.values()[std::size_t(i)];
    value = std::log(second.values()[std::size_t(i)] + added) - std::log(value + added);
  });
  double squares = 0;
  for (const float value : logarithm.values()) squares += double(value) * value;
  ratio.size = std::sqrt(squares / double(logarithm.values().size()));
  // A pixel p of the source is halfway at p + X/2.
  ratio.of_source = displaced(logarithm, forth);
  ratio.of_target = displaced(logarithm, back);
  return ratio;
}

LitImages in_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target, double t) {
  return {lit(source, ratio.of_source, [t](float l) { return float(1 + t * std::expm1(double(l))); }),
          lit(target, ratio.of_target, [t](float l) { return float(t + (1 - t) * std::exp(-double(l))); })};
}

LitImages in_mean_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target) {
  LitImages result{lit(source, ratio.of_source, [](float l) { return std::exp(0.5F * l); }),
                   lit(target, ratio.of_target, [](float l) { return std::exp(-0.5F * l); })};
  const auto cut = [](Image<float>& image, float most_of_other, const Image<float>& logarithm, float sign) {
    for (std::size_t i = 0; i < image.values().size(); ++i)
      image.values()[i] = std::min(image.values()[i], most_of_other * std::exp(sign * 0.5F * logarithm.values()[i]));
  };
  cut(result.source, largest(target), ratio.of_source, -1);
  cut(result.target, largest(source), ratio.of_target, 1);
  return result;
}

}  // namespace mq
