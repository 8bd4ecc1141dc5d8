#pragma once
/// Pictures of which one is the other moved along.

#include <cmath>

#include "cli/models.h"
#include "mq/image/colour.h"

namespace mq::test {

/// Soft blobs, moved to the right and down; the same in every channel but for its strength.
inline Image<float> blobs(int width, int height, double u, double v, int channels = 3) {
  Image<float> image(width, height, channels, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < colour_channels(channels); ++c)
        image(x, y, c) =
            float(0.5 + 0.2 * std::sin(0.31 * (x - u) + 0.8 * c) * std::cos(0.23 * (y - v)) +
                  0.15 * std::cos(0.11 * (x - u) - 0.17 * (y - v)));
  return image;
}

/// A wave over both charts of the strip: the left one spans columns 3.2 to 28.8, the right one 35.2
/// to 60.8, one surface without the gap. Moved by so many texels.
inline Image<float> wave_over_strip(double moved, int channels = 3) {
  Image<float> image(64, 48, channels);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < channels; ++c) {
        const double along = x < 32 ? x : x - 6.4;
        image(x, y, c) =
            float(0.5 + 0.3 * std::sin(0.35 * (along - moved)) * std::cos(0.2 * y + c));
      }
  return image;
}

inline Image<float> constant_field(int width, int height, float u, float v) {
  Image<float> field(width, height, 2);
  for (std::size_t i = 0; i < field.values().size(); i += 2)
    field.values()[i] = u, field.values()[i + 1] = v;
  return field;
}

}  // namespace mq::test
