#include "mq/model/detail/photograph_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/io/image_file.h"
#include "mq/io/photograph_file.h"
#include "mq/model/detail/tabled_curve.h"
#include "mq/model/photographs.h"

namespace mq {

namespace {

/// Into light, in place. What 8 bits store is looked up: the curve takes longer than reading a photograph.
void into_light(Texture& texture) {
  if (transfer(texture) == TransferFunction::linear) return;
  Image<float>& pixels = texture.pixels;
  if (texture.format.depth != Depth::u8) {
    pixels = decode(pixels, ColourSpace::linear, TransferFunction::srgb);
    return;
  }
  constexpr float largest = 255;
  std::array<float, 256> light{};
  for (std::size_t k = 0; k < light.size(); ++k) light[k] = float(linear_from_srgb(float(k) / largest));
  const int colours = colour_channels(pixels.channels());
  parallel_for(pixels.height(), [&](std::int64_t y) {
    for (int x = 0; x < pixels.width(); ++x)
      for (float& v : pixels.pixel(x, int(y)).first(std::size_t(colours)))
        v = light[std::size_t(std::clamp(v, 0.0F, 1.0F) * largest + 0.5F)];
  }, 16);
}

}  // namespace

PhotographLight PhotographLight::read(const Photograph& photograph) {
  const FittedCamera fitted = fitted_camera(photograph, picture_info(photograph.picture));
  Texture texture = read_photograph(photograph, fitted.turn);
  const int channels = texture.pixels.channels(), colours = colour_channels(channels);
  require(colours == 1 || colours == 3,
          fmt::format("{}: has {}, wanted grey or red, green and blue", photograph.picture.string(),
                      counted(colours, "colour channel")));
  PhotographLight result{.light = {}, .camera = fitted.camera, .remark = remark_on_size(photograph, fitted.camera)};
  into_light(texture);
  if (colours == 3) {
    result.light = std::move(texture.pixels);
    return result;
  }
  result.light = Image<float>(texture.pixels.width(), texture.pixels.height(), 3 + channels - colours);
  for (int y = 0; y < result.light.height(); ++y)
    for (int x = 0; x < result.light.width(); ++x) {
      for (int c = 0; c < 3; ++c) result.light(x, y, c) = texture.pixels(x, y, 0);
      if (channels > colours) result.light(x, y, 3) = texture.pixels(x, y, 1);
    }
  return result;
}

PhotographValues::PhotographValues(const TexturedModel& model, const TextureSignal& signal)
    : space_(signal.value_space().space),
      transfer_(TransferFunction::linear),
      channels_(signal.channels()) {
  const int colours = colour_channels(channels_);
  require(colours == 1 || colours == 3, fmt::format("{}: its textures have {}, wanted grey or red, green and blue",
                                                    model.model.path.string(), counted(colours, "colour channel")));
  if (space_ == ColourSpace::stored) transfer_ = common_transfer(model.model);
}

Image<float> PhotographValues::worked(Image<float> light) const {
  if (space_ != ColourSpace::stored) return decode(light, space_, TransferFunction::linear);
  if (transfer_ == TransferFunction::linear) return light;
  const auto colours = std::size_t(colour_channels(light.channels()));
  parallel_for(light.height(), [&](std::int64_t y) {
    for (int x = 0; x < light.width(); ++x)
      for (float& v : light.pixel(x, int(y)).first(colours)) v = display_of_light(v);
  }, 16);
  return light;
}

namespace {

double squared_radius_in(int width, int height, const Vector2& place) {
  return (2 * place - Vector2(width, height)).squaredNorm() / Vector2(width, height).squaredNorm();
}

}  // namespace

double radius_in(int width, int height, const Vector2& place) {
  return std::sqrt(squared_radius_in(width, height, place));
}

namespace {

/// Light ^ an exponent; over the root of light it is smooth enough to be tabled.
class TonedLight {
 public:
  explicit TonedLight(float exponent)
      : exponent_(exponent),
        curve_([&](double root) { return std::pow(root, 2 * double(exponent)); }, end, exponent == 1 ? 1 : 1 << 14) {}

  float operator()(float light) const {
    if (exponent_ == 1) return light;
    return light >= 0 && light < end * end ? curve_(std::sqrt(light)) : std::pow(std::max(light, 0.0F), exponent_);
  }

 private:
  static constexpr float end = 2;
  float exponent_;
  TabledCurve curve_;
};

}  // namespace

Image<float> PhotographValues::of(const PhotographLight& photograph, const Exposures& exposures, int number) const {
  const Image<float>& light = photograph.light;
  const int colours = colour_channels(channels_), alpha = light.channels() > 3 ? 1 : 0;
  Image<float> result(light.width(), light.height(), colours + alpha);
  const LightColour gain = exposures.gains[std::size_t(number)];
  const TonedLight toned(exposures.exponents[std::size_t(number)]);
  const TabledCurve corners([&](double square) { return exposures.falloff.correction(std::sqrt(square)); }, 1, 1 << 12);
  parallel_for(light.height(), [&](std::int64_t row) {
    const int y = int(row);
    for (int x = 0; x < light.width(); ++x) {
      const auto pixel = light.pixel(x, y);
      const float by = corners(float(squared_radius_in(light.width(), light.height(), {x + 0.5, y + 0.5})));
      std::array<float, 3> rgb;
      for (std::size_t c = 0; c < 3; ++c) rgb[c] = toned(pixel[c]) * gain[c] * by;
      if (colours == 1) result(x, y, 0) = (rgb[0] + rgb[1] + rgb[2]) / 3;
      for (int c = 0; c < colours && colours == 3; ++c) result(x, y, c) = rgb[std::size_t(c)];
      if (alpha) result(x, y, colours) = pixel[3];
    }
  }, 16);
  return worked(std::move(result));
}

Signal PhotographValues::of_colours(std::span<const LightColour> colours) const {
  const int wanted = colour_channels(channels_);
  Signal result(std::ssize(colours), wanted);
  constexpr std::size_t at_once = 1 << 16;
  for (std::size_t begin = 0; begin < colours.size(); begin += at_once) {
    const std::size_t count = std::min(at_once, colours.size() - begin);
    Image<float> light(int(count), 1, wanted);
    for (std::size_t k = 0; k < count; ++k) {
      const LightColour& c = colours[begin + k];
      if (wanted == 1) light(int(k), 0, 0) = (c[0] + c[1] + c[2]) / 3;
      for (int channel = 0; channel < wanted && wanted == 3; ++channel)
        light(int(k), 0, channel) = c[std::size_t(channel)];
    }
    const Image<float> values = worked(std::move(light));
    for (std::size_t k = 0; k < count; ++k)
      for (int c = 0; c < wanted; ++c) result(Eigen::Index(begin + k), c) = values(int(k), 0, c);
  }
  return result;
}

Signal PhotographValues::with_alpha(const Signal& values) const {
  const int colours = colour_channels(channels_);
  Signal result = Signal::Ones(values.rows(), channels_);
  result.leftCols(colours) = values.leftCols(colours);
  return result;
}

}  // namespace mq
