#include "mq/flow/detail/image_signals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/image/gaussian.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

/// A signal whose standard deviation is less of its largest value is constant.
constexpr double least_contrast = 1e-6;

template <class Values>
double sum_of_squares(const Values& values) {
  return parallel_sum(std::int64_t(values.size()), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t i = begin; i < end; ++i)
      sum += double(values[std::size_t(i)]) * values[std::size_t(i)];
    return sum;
  });
}

double largest_square(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, value * value);
  return largest;
}

void take_smooth_off(std::vector<double>& values, const Image<float>& like, double length) {
  std::vector<double> broad = values;
  smooth(broad, like.width(), like.height(), like.channels(), length * length);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= broad[i];
}

/// Of each channel the mean over both.
void take_means_off(std::vector<double>& first, std::vector<double>& second, int channels) {
  for (int c = 0; c < channels; ++c) {
    double sums[2] = {0, 0};
    for (std::size_t i = std::size_t(c); i < first.size(); i += std::size_t(channels)) {
      sums[0] += first[i];
      sums[1] += second[i];
    }
    const double mean = (sums[0] + sums[1]) / (2 * double(first.size()) / channels);
    for (std::size_t i = std::size_t(c); i < first.size(); i += std::size_t(channels)) {
      first[i] -= mean;
      second[i] -= mean;
    }
  }
}

struct Moments {
  double mean = 0, variance = 0;
};

Moments moments(const std::vector<double>& values, int channel, int channels) {
  Moments result;
  const double count = double(values.size()) / channels;
  for (std::size_t i = std::size_t(channel); i < values.size(); i += std::size_t(channels))
    result.mean += values[i] / count;
  for (std::size_t i = std::size_t(channel); i < values.size(); i += std::size_t(channels)) {
    const double off = values[i] - result.mean;
    result.variance += off * off / count;
  }
  return result;
}

/// Each channel of both to mean 0 and one variance.
void match(std::vector<double>& first, std::vector<double>& second, int channels, double least) {
  for (int c = 0; c < channels; ++c) {
    const Moments a = moments(first, c, channels), b = moments(second, c, channels);
    if (!(a.variance > least && b.variance > least)) continue;
    const double variance = (a.variance + b.variance) / 2;
    const auto bring = [&](std::vector<double>& values, const Moments& from) {
      const double factor = std::sqrt(variance / from.variance);
      for (std::size_t i = std::size_t(c); i < values.size(); i += std::size_t(channels))
        values[i] = factor * (values[i] - from.mean);
    };
    bring(first, a);
    bring(second, b);
  }
}

Image<float> scaled(const std::vector<double>& values, double factor, const Image<float>& like) {
  Image<float> signal(like.width(), like.height(), like.channels());
  for (std::size_t i = 0; i < values.size(); ++i) signal.values()[i] = float(factor * values[i]);
  return signal;
}

/// Along a line of `size` values `step` apart, at place i of it.
float difference(const float* values, std::ptrdiff_t step, int i, int size) {
  const auto at = [&](int k) { return values[k * step]; };
  if (size == 1) return 0;
  if (i == 0) return at(1) - at(0);
  if (i == size - 1) return at(0) - at(-1);
  if (i == 1 || i == size - 2) return 0.5F * (at(1) - at(-1));
  return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) * (1.0F / 12);
}

}  // namespace

double mean(const Image<float>& signal) {
  const auto values = signal.values();
  return parallel_sum(std::ssize(values), 0.0,
                      [&](std::int64_t begin, std::int64_t end) {
                        double sum = 0;
                        for (std::int64_t i = begin; i < end; ++i) sum += values[std::size_t(i)];
                        return sum;
                      }) /
         double(values.size());
}

double mean_square(const Image<float>& signal) {
  return signal.empty() ? 0 : sum_of_squares(signal.values()) / double(signal.values().size());
}

SignalPair flow_signals(const Image<float>& source, const Image<float>& target, double length,
                        ImageLight light) {
  std::vector<double> first(source.values().begin(), source.values().end());
  std::vector<double> second(target.values().begin(), target.values().end());
  const double largest = std::sqrt(std::max(largest_square(first), largest_square(second)));
  if (length > 0) {
    take_smooth_off(first, source, length);
    take_smooth_off(second, target, length);
  } else {
    take_means_off(first, second, source.channels());
  }
  if (light == ImageLight::matched)
    match(first, second, source.channels(), std::pow(least_contrast * largest, 2));
  const double deviation =
      std::sqrt((sum_of_squares(first) + sum_of_squares(second)) / double(2 * first.size()));
  const bool constant = !(deviation > least_contrast * largest);
  return {scaled(first, constant ? 0 : 1 / deviation, source),
          scaled(second, constant ? 0 : 1 / deviation, target)};
}

Image<float> at_scale(const Image<float>& signal, double deviation, int width, int height) {
  const double spacing = std::sqrt(double(signal.width()) / width * signal.height() / height);
  // A mean over n pixels has the variance (n² − 1)/12.
  const double variance =
      (deviation * deviation - (spacing * spacing - 1) / 12) / (spacing * spacing);
  const bool same = width == signal.width() && height == signal.height();
  return smoothed(same ? signal : area_scaled(signal, width, height), std::max(0.0, variance / 2));
}

Slope slope(const Image<float>& signal, int x, int y, int channel) {
  const float* value = &signal(x, y, channel);
  const std::ptrdiff_t channels = signal.channels();
  return {difference(value, channels, x, signal.width()),
          difference(value, channels * signal.width(), y, signal.height())};
}

Image<float> with_slopes(const Image<float>& signal, double factor) {
  const int channels = signal.channels();
  Image<float> result(signal.width(), signal.height(), 3 * channels);
  parallel_for(
      signal.height(),
      [&](std::int64_t row) {
        for (int x = 0; x < signal.width(); ++x)
          for (int c = 0; c < channels; ++c) {
            const Slope s = slope(signal, x, int(row), c);
            result(x, int(row), c) = signal(x, int(row), c);
            result(x, int(row), channels + 2 * c) = float(factor) * s.x;
            result(x, int(row), channels + 2 * c + 1) = float(factor) * s.y;
          }
      },
      8);
  return result;
}

}  // namespace mq
