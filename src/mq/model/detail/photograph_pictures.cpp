#include "mq/model/detail/photograph_pictures.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/image/resample.h"
#include "mq/model/detail/tabled_curve.h"

namespace mq {
namespace {

Image<float> display_brightness(const Image<float>& light) {
  Image<float> grey(light.width(), light.height(), 1);
  parallel_for(light.height(), [&](std::int64_t y) {
    for (int x = 0; x < light.width(); ++x) {
      const auto pixel = light.pixel(x, int(y));
      grey(x, int(y)) = display_of_light((pixel[0] + pixel[1] + pixel[2]) / 3);
    }
  }, 64);
  return grey;
}

}  // namespace

Image<float> squared_detail(const Image<float>& grey, double step) {
  Image<float> result(grey.width(), grey.height(), 1);
  parallel_for(grey.height(), [&](std::int64_t row) {
    const int y = int(row), below = std::min(y + 1, grey.height() - 1);
    for (int x = 0; x < grey.width(); ++x) {
      const float v = grey(x, y);
      const float dx = grey(std::min(x + 1, grey.width() - 1), y) - v, dy = grey(x, below) - v;
      result(x, y) = float(step * step) * (dx * dx + dy * dy);
    }
  }, 64);
  return result;
}

Image<float> reduced(const Image<float>& image, double factor) {
  const auto side = [&](int size) { return std::max(1, int(std::lround(size / factor))); };
  if (factor <= 1) return image;
  return area_scaled(image, side(image.width()), side(image.height()));
}

Image<float> picture_to_align(const Image<float>& light, double pixels_per_texel, double most_pixels) {
  const double size = double(light.width()) * light.height();
  return display_brightness(reduced(light, std::max({1.0, pixels_per_texel, std::sqrt(size / most_pixels)})));
}

Image<float> picture_to_look_at(const Image<float>& light, double pixels_per_texel) {
  const double fine = std::max(1.0, pixels_per_texel), coarse = std::max(1.0, 2 * pixels_per_texel);
  const Image<float> at_texels = reduced(light, fine);
  const double step = pixels_per_texel / std::max(1.0, double(light.width()) / at_texels.width());
  const Image<float> colours = reduced(light, coarse);
  const Image<float> detail =
      area_scaled(squared_detail(display_brightness(at_texels), step), colours.width(), colours.height());
  Image<float> result(colours.width(), colours.height(), channel_of_alpha + 1);
  for (int y = 0; y < result.height(); ++y)
    for (int x = 0; x < result.width(); ++x) {
      for (int c = 0; c < 3; ++c) result(x, y, c) = colours(x, y, c);
      result(x, y, channel_of_detail) = detail(x, y);
      result(x, y, channel_of_alpha) = colours.channels() > 3 ? std::clamp(colours(x, y, 3), 0.0F, 1.0F) : 1.0F;
    }
  return result;
}

}  // namespace mq
