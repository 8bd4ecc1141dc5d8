#include "mq/image/colour.h"

#include "mq/base/parallel.h"

namespace mq {
namespace {

template <class Map>
Image<float> map_colours(const Image<float>& image, const Map& map) {
  Image<float> mapped = image;
  const int colours = colour_channels(image.channels());
  parallel_for(image.height(), [&](std::int64_t y) {
    for (int x = 0; x < image.width(); ++x)
      for (float& v : mapped.pixel(x, int(y)).first(colours)) v = float(map(double(v)));
  }, 16);
  return mapped;
}

double light(double v, Transfer transfer) {
  return transfer == Transfer::srgb ? linear_from_srgb(v) : v;
}

double stored(double v, Transfer transfer) {
  return transfer == Transfer::srgb ? srgb_from_linear(v) : v;
}

}  // namespace

Image<float> decode(const Image<float>& image, ColourSpace space, Transfer transfer) {
  if (space == ColourSpace::log)
    return map_colours(image, [=](double v) { return log_from_linear(light(v, transfer)); });
  if (space == ColourSpace::linear && transfer == Transfer::srgb)
    return map_colours(image, linear_from_srgb);
  return image;
}

Image<float> encode(const Image<float>& image, ColourSpace space, Transfer transfer) {
  if (space == ColourSpace::log)
    return map_colours(image, [=](double v) { return stored(linear_from_log(v), transfer); });
  if (space == ColourSpace::linear && transfer == Transfer::srgb)
    return map_colours(image, srgb_from_linear);
  return image;
}

Image<float> as_rgb(const Image<float>& image, const Colour& behind) {
  const int channels = image.channels();
  const bool alpha = channels == 2 || channels == 4;
  Image<float> rgb(image.width(), image.height(), 3);
  parallel_for(image.height(), [&](std::int64_t y) {
    for (int x = 0; x < image.width(); ++x) {
      const auto from = image.pixel(x, int(y));
      const float cover = alpha ? from[channels - 1] : 1;
      for (int k = 0; k < 3; ++k)
        rgb(x, int(y), k) = cover * from[channels >= 3 ? k : 0] + (1 - cover) * behind[k];
    }
  }, 16);
  return rgb;
}

}  // namespace mq
