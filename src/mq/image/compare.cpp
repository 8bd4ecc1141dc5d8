#include "mq/image/compare.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// What the blocks of rows add up to.
struct Part {
  std::vector<double> squares;  ///< per channel
  std::int64_t pixels = 0;
  double largest = -1;
  int x = 0, y = 0, channel = 0;

  Part operator+(const Part& later) const {
    Part sum = *this;
    sum.squares.resize(std::max(squares.size(), later.squares.size()));
    for (std::size_t k = 0; k < later.squares.size(); ++k) sum.squares[k] += later.squares[k];
    sum.pixels += later.pixels;
    if (later.largest > largest) {
      sum.largest = later.largest;
      sum.x = later.x, sum.y = later.y, sum.channel = later.channel;
    }
    return sum;
  }
};

void require_same_shape(const Image<float>& a, const Image<float>& b, const Image<float>* mask) {
  if (a.width() != b.width() || a.height() != b.height() || a.channels() != b.channels())
    throw InvalidInput(fmt::format(
        "pictures of {} x {} x {} and {} x {} x {} (width, height, channels) cannot be compared",
        a.width(), a.height(), a.channels(), b.width(), b.height(), b.channels()));
  if (mask != nullptr && (mask->width() != a.width() || mask->height() != a.height()))
    throw InvalidInput(fmt::format("the coverage has {} x {} pixels, the pictures {} x {}",
                                   mask->width(), mask->height(), a.width(), a.height()));
}

Part compare_rows(const Image<float>& a, const Image<float>& b, const Image<float>* mask, int begin,
                  int end) {
  Part part;
  part.squares.assign(a.channels(), 0);
  for (int y = begin; y < end; ++y)
    for (int x = 0; x < a.width(); ++x) {
      if (mask != nullptr && !((*mask)(x, y) > 0)) continue;
      ++part.pixels;
      for (int k = 0; k < a.channels(); ++k) {
        const double difference = double(a(x, y, k)) - b(x, y, k);
        if (!std::isfinite(difference))
          throw InvalidInput(
              fmt::format("pixel (column {}, row {}) holds {} and {}: only finite "
                          "values can be compared",
                          x, y, a(x, y, k), b(x, y, k)));
        part.squares[k] += difference * difference;
        if (std::abs(difference) > part.largest) {
          part.largest = std::abs(difference);
          part.x = x, part.y = y, part.channel = k;
        }
      }
    }
  return part;
}

}  // namespace

Comparison compare(const Image<float>& a, const Image<float>& b, const CompareOptions& options) {
  require_same_shape(a, b, options.coverage);
  const Part sum = parallel_sum(
      a.height(), Part(),
      [&](std::int64_t begin, std::int64_t end) {
        return compare_rows(a, b, options.coverage, int(begin), int(end));
      },
      64);
  require(sum.pixels > 0, "no pixel is covered: there is nothing to compare");

  Comparison result;
  result.pixels = sum.pixels;
  double squares = 0;
  for (const double s : sum.squares) {
    squares += s;
    result.channel_rms.push_back(std::sqrt(s / double(sum.pixels)));
  }
  result.rms = std::sqrt(squares / double(sum.pixels) / a.channels());
  if (result.rms > 0) result.psnr = 20 * std::log10(options.peak / result.rms);
  result.largest = sum.largest;
  result.x = sum.x, result.y = sum.y, result.channel = sum.channel;
  result.a = a(sum.x, sum.y, sum.channel), result.b = b(sum.x, sum.y, sum.channel);
  return result;
}

}  // namespace mq
