#include "mq/image/gaussian.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Weights of a Gaussian at 0, 1, ... pixels, of sum 1 with both sides, for lines of `size` pixels
/// that are mirrored at their ends: as these repeat after 2·size, what lies beyond is added to what
/// it repeats. From a deviation of three sizes on nothing but the mean is left, to 10⁻¹⁹.
std::vector<double> gaussian(double weight, int size) {
  const double deviation = std::min(std::sqrt(2 * weight), 3.0 * size);
  const int radius = int(std::ceil(4 * deviation)), period = 2 * size;
  std::vector<double> kernel(std::size_t(std::min(radius, size)) + 1, 0.0);
  double sum = 0;
  for (int i = 0; i <= radius; ++i) {
    const double value = std::exp(-0.5 * i * i / (deviation * deviation));
    const int repeated = i % period <= size ? i % period : period - i % period;
    // Pixel 0 stands for itself alone; 2·size, 4·size, ... come to it from either side.
    kernel[std::size_t(repeated)] += repeated == 0 && i > 0 ? 2 * value : value;
    sum += (i ? 2 : 1) * value;
  }
  for (double& k : kernel) k /= sum;
  return kernel;
}

/// The pixel that one beyond the border mirrors.
int mirrored(int i, int size) {
  const int period = 2 * size;
  i = ((i % period) + period) % period;
  return i < size ? i : period - 1 - i;
}

/// to += factor · from.
void add(const double* from, double factor, std::span<double> to) {
  for (std::size_t n = 0; n < to.size(); ++n) to[n] += factor * from[n];
}

}  // namespace

void smooth(std::span<double> values, int width, int height, int channels, double weight) {
  require(weight >= 0, fmt::format("a weight of {} is negative", weight));
  const std::size_t stride = std::size_t(channels), row = stride * width;
  require(values.size() == row * height, "a value is needed for every channel of every pixel");
  if (weight == 0 || values.empty()) return;
  const std::vector<double> along_x = gaussian(weight, width), along_y = gaussian(weight, height);
  std::vector<double> rows(values.size());
  parallel_blocks(height, 8, [&](std::int64_t begin, std::int64_t end) {
    const int radius = int(along_x.size()) - 1;
    std::vector<double> wide(row + 2 * radius * stride);
    for (std::int64_t y = begin; y < end; ++y) {
      for (int x = -radius; x < width + radius; ++x)
        std::copy_n(&values[row * std::size_t(y) + stride * std::size_t(mirrored(x, width))],
                    stride, &wide[std::size_t(x + radius) * stride]);
      const std::span<double> to(&rows[row * std::size_t(y)], row);
      for (int i = -radius; i <= radius; ++i)
        add(wide.data() + std::size_t(i + radius) * stride, along_x[std::size_t(std::abs(i))], to);
    }
  });
  parallel_for(
      height,
      [&](std::int64_t y) {
        const int radius = int(along_y.size()) - 1;
        const std::span<double> to = values.subspan(row * std::size_t(y), row);
        std::ranges::fill(to, 0.0);
        for (int i = -radius; i <= radius; ++i)
          add(&rows[row * std::size_t(mirrored(int(y) + i, height))],
              along_y[std::size_t(std::abs(i))], to);
      },
      8);
}

Image<float> smoothed(const Image<float>& image, double weight) {
  std::vector<double> values(image.values().begin(), image.values().end());
  smooth(values, image.width(), image.height(), image.channels(), weight);
  Image<float> result = image;
  std::ranges::copy(values, result.values().begin());
  return result;
}

}  // namespace mq
