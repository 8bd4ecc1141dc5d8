// Noise on a texture, and how much of it is left.
//
//     texture_noise_bench TRUTH NOISY.png           writes TRUTH with Gaussian noise added
//     texture_noise_bench TRUTH MASK PICTURE...     root mean square error of each where the mask
//     is
//                                                   white, values 0 to 1

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/io/model.h"

namespace mq {
namespace {

/// Standard deviation of the noise.
constexpr double deviation = 0.08;

/// Box and Muller's two uniform numbers of the count 2k and 2k + 1.
double gaussian(const Random& random, std::uint64_t k) {
  const double radius = std::sqrt(-2 * std::log(1 - random.uniform(2 * k)));
  return radius * std::cos(2 * std::numbers::pi * random.uniform(2 * k + 1));
}

void add_noise(const std::string& truth, const std::string& noisy) {
  Texture texture = read_texture(truth);
  const Random random(1);
  std::uint64_t k = 0;
  for (float& value : texture.pixels.values())
    value = float(std::clamp(value + deviation * gaussian(random, k++), 0.0, 1.0));
  write_texture(noisy, texture);
}

double error(const Image<float>& truth, const Image<float>& mask, const Image<float>& picture) {
  require(truth.width() == picture.width() && truth.height() == picture.height() &&
              truth.channels() == picture.channels() && mask.width() == truth.width() &&
              mask.height() == truth.height(),
          "pictures of one size are needed");
  double sum = 0, count = 0;
  for (int y = 0; y < truth.height(); ++y)
    for (int x = 0; x < truth.width(); ++x) {
      if (mask(x, y) < 0.5F) continue;
      for (int c = 0; c < truth.channels(); ++c, ++count)
        sum += std::pow(picture(x, y, c) - truth(x, y, c), 2);
    }
  return std::sqrt(sum / count);
}

void compare(int argc, char** argv) {
  const Image<float> truth = read_texture(argv[1]).pixels, mask = read_texture(argv[2]).pixels;
  for (int i = 3; i < argc; ++i)
    fmt::print("{} {:.4f}\n", argv[i], error(truth, mask, read_texture(argv[i]).pixels));
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: texture_noise_bench TRUTH NOISY | TRUTH MASK PICTURE...\n");
    return 2;
  }
  try {
    if (argc == 3)
      mq::add_noise(argv[1], argv[2]);
    else
      mq::compare(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
