#pragma once
/// Pictures that shock filters are tried on.

#include <cmath>
#include <cstdint>

#include "mq/base/random.h"
#include "mq/image/image.h"

namespace mq::fixtures {

/// Smooth shapes in several channels.
inline Image<float> shapes(int width, int height, int channels = 1) {
  Image<float> image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image(x, y, c) = float(
            0.5 + 0.3 * std::tanh(std::hypot(x - 0.45 * width, y - 0.5 * height) / 4 - 4 - c) +
            0.15 * std::sin(0.11 * x + 0.07 * y + c));
  return image;
}

inline Image<float> noisy(Image<float> image, double amplitude) {
  const Random random(3);
  std::uint64_t i = 0;
  for (float& v : image.values()) v += float(random.uniform(i++, -amplitude, amplitude));
  return image;
}

}  // namespace mq::fixtures
