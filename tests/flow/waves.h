#pragma once
/// Pictures with a known motion between them.

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "mq/base/random.h"
#include "mq/image/image.h"

namespace mq::test {

/// A sum of waves of many directions, of lengths from `shortest` to `longest` and as strong as they
/// are long: a band-limited signal of variance ½.
class Waves {
 public:
  Waves(double shortest, double longest, std::uint64_t seed = 3, int count = 300) {
    const Random random(seed);
    std::uint64_t drawn = 0;
    double power = 0;
    for (int i = 0; i < count; ++i) {
      const double length = shortest * std::pow(longest / shortest, random.uniform(drawn++));
      const double angle = 2 * std::numbers::pi * random.uniform(drawn++),
                   k = 2 * std::numbers::pi / length;
      waves_.push_back({k * std::cos(angle), k * std::sin(angle),
                        2 * std::numbers::pi * random.uniform(drawn++), length});
      power += length * length;
    }
    for (auto& wave : waves_) wave[3] /= std::sqrt(power);
  }

  double operator()(double x, double y) const {
    double sum = 0;
    for (const auto& [kx, ky, phase, size] : waves_)
      sum += size * std::cos(kx * x + ky * y + phase);
    return sum;
  }

 private:
  std::vector<std::array<double, 4>> waves_;
};

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

using Signal2 = std::function<double(double, double)>;

inline Image<float> drawn(int width, int height, const Signal2& signal) {
  Image<float> image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image(x, y) = float(signal(x, y));
  return image;
}

using Motion = std::function<std::array<double, 2>(double, double)>;

inline Image<float> field_of(int width, int height, const Motion& motion) {
  Image<float> field(width, height, 2);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto [u, v] = motion(x, y);
      field(x, y, 0) = float(u), field(x, y, 1) = float(v);
    }
  return field;
}

/// Mean distance of a field to the true one, without a margin.
inline double endpoint_error(const Image<float>& field, int margin, const Motion& truth) {
  double sum = 0;
  int count = 0;
  for (int y = margin; y < field.height() - margin; ++y)
    for (int x = margin; x < field.width() - margin; ++x, ++count) {
      const auto [u, v] = truth(x, y);
      sum += std::hypot(field(x, y, 0) - u, field(x, y, 1) - v);
    }
  return sum / count;
}

}  // namespace mq::test
