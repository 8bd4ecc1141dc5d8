#include "mq/image/resample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// The part of the old pixels [first, first + weights.size()) in one new pixel; weights sum to 1.
struct Cover {
  int first = 0;
  std::vector<double> weights;
};

std::vector<Cover> covers(int from, int to) {
  std::vector<Cover> result(to);
  for (int i = 0; i < to; ++i) {
    const double low = double(i) * from / to, high = double(i + 1) * from / to;
    Cover& cover = result[i];
    cover.first = int(low);
    for (int k = cover.first; k < from && k < high; ++k)
      cover.weights.push_back((std::min(high, k + 1.0) - std::max(low, double(k))) / (high - low));
  }
  return result;
}

}  // namespace

void sample(const Image<float>& image, double column, double row, Wrap wrap,
            std::span<float> values) {
  const double left = std::floor(column), top = std::floor(row);
  const double s = column - left, t = row - top;
  const int x0 = wrapped(std::int64_t(left), image.width(), wrap);
  const int x1 = s > 0 ? wrapped(std::int64_t(left) + 1, image.width(), wrap) : x0;
  const int y0 = wrapped(std::int64_t(top), image.height(), wrap);
  const int y1 = t > 0 ? wrapped(std::int64_t(top) + 1, image.height(), wrap) : y0;
  const auto a = image.pixel(x0, y0), b = image.pixel(x1, y0);
  const auto c = image.pixel(x0, y1), d = image.pixel(x1, y1);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double upper = a[k] + s * (double(b[k]) - a[k]);
    const double lower = c[k] + s * (double(d[k]) - c[k]);
    values[k] = float(upper + t * (lower - upper));
  }
}

Image<float> area_scaled(const Image<float>& image, int width, int height) {
  if (image.empty() || width < 1 || height < 1)
    throw InvalidInput(fmt::format("a picture of {} x {} pixels cannot be scaled to {} x {}",
                                   image.width(), image.height(), width, height));
  const std::vector<Cover> columns = covers(image.width(), width);
  const std::vector<Cover> rows = covers(image.height(), height);
  const int channels = image.channels();
  Image<float> scaled(width, height, channels);
  parallel_for(
      height,
      [&](std::int64_t y) {
        std::vector<double> line(std::size_t(image.width()) * channels);
        const Cover& row = rows[y];
        for (std::size_t j = 0; j < row.weights.size(); ++j) {
          const float* from = &image(0, row.first + int(j));
          for (std::size_t i = 0; i < line.size(); ++i) line[i] += row.weights[j] * from[i];
        }
        for (int x = 0; x < width; ++x)
          for (int k = 0; k < channels; ++k) {
            double sum = 0;
            for (std::size_t i = 0; i < columns[x].weights.size(); ++i)
              sum += columns[x].weights[i] * line[(columns[x].first + i) * channels + k];
            scaled(x, int(y), k) = float(sum);
          }
      },
      8);
  return scaled;
}

Image<float> fitted(const Image<float>& image, int side) {
  const int longest = std::max(image.width(), image.height());
  if (longest <= side) return image;
  const auto shrink = [&](int n) {
    return std::max(1, int(std::lround(double(n) * side / longest)));
  };
  return area_scaled(image, shrink(image.width()), shrink(image.height()));
}

Image<float> cropped(const Image<float>& image, int x, int y, int width, int height) {
  if (x < 0 || y < 0 || width < 1 || height < 1 || x + width > image.width() ||
      y + height > image.height())
    throw InvalidInput(
        fmt::format("the rectangle {} x {} at ({}, {}) leaves a picture of {} x {} "
                    "pixels",
                    width, height, x, y, image.width(), image.height()));
  Image<float> part(width, height, image.channels());
  for (int row = 0; row < height; ++row) {
    const float* from = &image(x, y + row);
    std::copy(from, from + std::size_t(width) * image.channels(), &part(0, row));
  }
  return part;
}

}  // namespace mq
