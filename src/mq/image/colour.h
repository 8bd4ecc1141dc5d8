#pragma once
/// Colour spaces in which values can be processed (`--space`), one value at a time. Every map is
/// odd, strictly increasing and invertible on all real numbers, so that values a filter drives
/// below 0 or above 1 survive the way there and back.

#include <array>
#include <cmath>
#include <optional>

#include "mq/image/image.h"

namespace mq {

/// Red, green, blue as displayed, 0 to 1.
using Colour = std::array<float, 3>;

enum class ColourSpace {
  stored,  ///< as the file holds them
  linear,  ///< light: the sRGB curve undone
  log      ///< the logarithm of light, straightened near 0: steps of equal ratio are equal
};

/// The sRGB curve undone (IEC 61966-2-1): ((v + 0.055) / 1.055)^2.4, v / 12.92 below 0.04045.
inline double linear_from_srgb(double v) {
  const double a = std::abs(v);
  return std::copysign(a <= 0.04045 ? a / 12.92 : std::pow((a + 0.055) / 1.055, 2.4), v);
}

inline double srgb_from_linear(double v) {
  const double a = std::abs(v);
  return std::copysign(a <= 0.0031308 ? a * 12.92 : 1.055 * std::pow(a, 1 / 2.4) - 0.055, v);
}

/// Where the logarithm turns into a straight line: the smallest step of 8-bit sRGB, in light.
inline constexpr double log_threshold = 1 / (255 * 12.92);

/// asinh(v / 2e), e = `log_threshold`: log(v / e) for v far above e, v / 2e near 0, odd.
inline double log_from_linear(double v) { return std::asinh(v / (2 * log_threshold)); }
inline double linear_from_log(double v) { return std::sinh(v) * (2 * log_threshold); }

/// What a file's values are.
enum class TransferFunction {
  srgb,   ///< display values: PNG, JPEG, BMP, TGA, integer TIFF
  linear  ///< light: EXR, floating-point TIFF
};

/// What values are of light.
enum class LightLaw {
  log,     ///< its logarithm: a gain adds
  linear,  ///< light itself
  display  ///< display values, 1 for white (`linear_from_srgb`)
};

/// Which channels are colours: all but the last of two or four, which is alpha.
inline int colour_channels(int channels) {
  return channels == 2 || channels == 4 ? channels - 1 : channels;
}

inline bool has_alpha(int channels) { return colour_channels(channels) < channels; }

/// The picture's colour channels taken into `space`; alpha stays.
Image<float> decode(const Image<float>& image, ColourSpace space, TransferFunction transfer);

/// The way back.
Image<float> encode(const Image<float>& image, ColourSpace space, TransferFunction transfer);

/// The displayed colour of a lightness (0 to 1), chroma and hue (degrees) of OKLab (Ottosson, A
/// perceptual color space for image processing, 2020); where the display cannot show that much
/// chroma, with the most it can.
Colour colour_of(double lightness, double chroma, double hue);

/// The picture in red, green and blue: grey is spread over the three, further channels are left out. It is as it looks
/// in front of `behind`, with which alpha blends; where there is nothing behind, alpha is left out as well, and what
/// lies under it is shown.
Image<float> as_rgb(const Image<float>& image, const std::optional<Colour>& behind = Colour{1, 1, 1});

}  // namespace mq
