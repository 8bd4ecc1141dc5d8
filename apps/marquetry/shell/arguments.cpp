#include "shell/arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace mq::app {

std::optional<std::vector<double>> parse_numbers(const std::string& text, std::size_t count) {
  std::vector<double> values(count);
  const char* at = text.data();
  const char* end = text.data() + text.size();
  for (std::size_t k = 0; k < count; ++k) {
    const auto [stop, error] = std::from_chars(at, end, values[k]);
    if (error != std::errc() || !std::isfinite(values[k])) return std::nullopt;
    const bool last = k + 1 == count;
    if (last != (stop == end) || (!last && *stop != ',')) return std::nullopt;
    at = last ? stop : stop + 1;
  }
  return values;
}

std::string as_typed(double value) {
  constexpr double smallest_written_out = 1e-3;
  if (value == 0 || std::abs(value) >= smallest_written_out) return fmt::format("{:g}", value);
  const int exponent = int(std::floor(std::log10(std::abs(value))));  // "1e-4"
  return fmt::format("{:g}e{}", value / std::pow(10.0, exponent), exponent);
}

std::string as_typed(const Length& length) {
  const char* unit = length.unit == Length::Unit::percent  ? "%"
                     : length.unit == Length::Unit::texels ? "tx"
                                                           : "";
  return as_typed(length.value) + unit;
}

std::optional<std::array<int, 2>> parse_size(std::string text) {
  if (text.find('x') == std::string::npos) text += "x" + text;
  std::ranges::replace(text, 'x', ',');
  const auto size = parse_numbers(text, 2);
  if (!size) return std::nullopt;
  for (const double side : *size)
    if (side < 1 || side > 16384 || side != std::floor(side)) return std::nullopt;
  return std::array{int((*size)[0]), int((*size)[1])};
}

std::optional<Backdrop> parse_backdrop(const std::string& text) {
  using enum Backdrop::Kind;
  if (text == "gradient") return Backdrop{gradient};
  if (text == "transparent") return Backdrop{transparent};
  if (text == "white") return Backdrop{colour, {1, 1, 1}};
  if (text == "black") return Backdrop{colour, {0, 0, 0}};
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  unsigned rgb = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 1, end, rgb, 16);
  if (error != std::errc() || stop != end) return std::nullopt;
  const auto part = [&](int shift) { return float(rgb >> shift & 255) / 255; };
  return Backdrop{colour, {part(16), part(8), part(0)}};
}

}  // namespace mq::app
