#include "mq/image/colour.h"

#include <algorithm>
#include <numbers>

#include "mq/base/parallel.h"

namespace mq {
namespace {

template <class Map>
Image<float> map_colours(const Image<float>& image, const Map& map) {
  Image<float> mapped = image;
  const int colours = colour_channels(image.channels());
  parallel_for(
      image.height(),
      [&](std::int64_t y) {
        for (int x = 0; x < image.width(); ++x)
          for (float& v : mapped.pixel(x, int(y)).first(colours)) v = float(map(double(v)));
      },
      16);
  return mapped;
}

double light(double v, TransferFunction transfer) {
  return transfer == TransferFunction::srgb ? linear_from_srgb(v) : v;
}

double stored(double v, TransferFunction transfer) {
  return transfer == TransferFunction::srgb ? srgb_from_linear(v) : v;
}

/// OKLab to linear sRGB (Ottosson 2020).
std::array<double, 3> light_from_oklab(double L, double a, double b) {
  const double l = std::pow(L + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(L - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(L - 0.0894841775 * a - 1.2914855480 * b, 3);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

}  // namespace

Image<float> decode(const Image<float>& image, ColourSpace space, TransferFunction transfer) {
  if (space == ColourSpace::log)
    return map_colours(image, [=](double v) { return log_from_linear(light(v, transfer)); });
  if (space == ColourSpace::linear && transfer == TransferFunction::srgb)
    return map_colours(image, linear_from_srgb);
  return image;
}

Image<float> encode(const Image<float>& image, ColourSpace space, TransferFunction transfer) {
  if (space == ColourSpace::log)
    return map_colours(image, [=](double v) { return stored(linear_from_log(v), transfer); });
  if (space == ColourSpace::linear && transfer == TransferFunction::srgb)
    return map_colours(image, srgb_from_linear);
  return image;
}

Colour colour_of(double lightness, double chroma, double hue) {
  const double angle = hue * std::numbers::pi / 180;
  const auto light = [&](double c) {
    return light_from_oklab(lightness, c * std::cos(angle), c * std::sin(angle));
  };
  const auto fits = [&](double c) {
    return std::ranges::all_of(light(c), [](double v) { return v >= 0 && v <= 1; });
  };
  double least = 0, most = chroma;
  if (!fits(most))
    for (int step = 0; step < 40; ++step) {
      const double middle = (least + most) / 2;
      (fits(middle) ? least : most) = middle;
    }
  Colour colour;
  const auto rgb = light(fits(most) ? most : least);
  for (int k = 0; k < 3; ++k) colour[k] = float(srgb_from_linear(std::clamp(rgb[k], 0.0, 1.0)));
  return colour;
}

Image<float> as_rgb(const Image<float>& image, const std::optional<Colour>& behind) {
  const int channels = image.channels();
  const bool blends = behind && has_alpha(channels);
  Image<float> rgb(image.width(), image.height(), 3);
  parallel_for(
      image.height(),
      [&](std::int64_t y) {
        for (int x = 0; x < image.width(); ++x) {
          const auto from = image.pixel(x, int(y));
          const float cover = from[channels - 1];
          for (int k = 0; k < 3; ++k) {
            const float own = from[channels >= 3 ? k : 0];
            rgb(x, int(y), k) = blends ? cover * own + (1 - cover) * (*behind)[k] : own;
          }
        }
      },
      16);
  return rgb;
}

}  // namespace mq
