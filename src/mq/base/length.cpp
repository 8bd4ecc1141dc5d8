#include "mq/base/length.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "mq/base/error.h"

namespace mq {

Length parse_length(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  const std::string unit(stop, end);
  const bool known = unit.empty() || unit == "%" || unit == "tx";
  if (error != std::errc() || !known || !std::isfinite(value) || value < 0)
    throw InvalidInput(fmt::format(
        "'{}' is not a length: write a number that is not negative, alone (model units), with % "
        "(percent of the square root of the area) or with tx (texels), such as 0.02, 1% or 8tx",
        text));
  if (unit == "%") return {value, Length::Unit::percent};
  if (unit == "tx") return {value, Length::Unit::texels};
  return {value, Length::Unit::model};
}

double alpha_from_length(const Length& length, const SurfaceScale& scale) {
  require(scale.area > 0, "the surface has no area that can be computed with, so that lengths mean nothing on it: scale "
          "the model up if it is tiny, or give it triangles that have area");
  const double root = std::sqrt(scale.area);
  const auto squared = [](double x) { return x * x; };
  switch (length.unit) {
    case Length::Unit::model: return squared(length.value / root);
    case Length::Unit::percent: return squared(length.value / 100);
    case Length::Unit::texels:
      require(scale.texel_spacing > 0, "a length in texels needs a texture");
      return squared(length.value * scale.texel_spacing / root);
    case Length::Unit::alpha: return length.value;
  }
  return 0;
}

double weight_from_length(const Length& length, const SurfaceScale& scale) {
  return alpha_from_length(length, scale) * scale.area;
}

}  // namespace mq
