// Both maps are curves in OKLab given by lightness, hue and a wished-for chroma, which is reduced
// where the display cannot show it. They are tabulated once.

#include "mq/draw/false_colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/detail/text.h"

namespace mq {
namespace {

constexpr int table_size = 256;
using Table = std::array<Colour, table_size>;

Table sequential_table() {
  Table table;
  for (int i = 0; i < table_size; ++i) {
    const double t = double(i) / (table_size - 1);
    const double hue = 295 - 190 * std::pow(t, 0.9);
    table[i] = colour_of(0.26 + 0.69 * t, 0.09 + 0.09 * t, hue);
  }
  return table;
}

Table diverging_table() {
  Table table;
  for (int i = 0; i < table_size; ++i) {
    const double t = 2.0 * i / (table_size - 1) - 1, size = std::abs(t);
    table[i] = colour_of(0.965 - 0.535 * size, 0.19 * std::pow(size, 0.85), t < 0 ? 255 : 27);
  }
  return table;
}

double place_on(const FalseColour& scale, double value) {
  const double width = scale.high - scale.low;
  return width > 0 ? std::clamp((value - scale.low) / width, 0.0, 1.0) : 0.5;
}

constexpr Colour line_colour = {0.1f, 0.1f, 0.12f};

}  // namespace

Colour false_colour(double value, const FalseColour& scale) {
  static const Table sequential = sequential_table(), diverging = diverging_table();
  if (std::isnan(value)) return {0.5f, 0.5f, 0.5f};
  const Table& table = scale.map == FalseColour::Map::sequential ? sequential : diverging;
  const double place = place_on(scale, value) * (table_size - 1);
  const int i = std::min(int(place), table_size - 2);
  const float t = float(place - i);
  Colour colour;
  for (int k = 0; k < 3; ++k) colour[k] = table[i][k] + t * (table[i + 1][k] - table[i][k]);
  return colour;
}

int isoline_band(double value, const FalseColour& scale) {
  if (std::isnan(value)) return -1;
  return std::min(int(place_on(scale, value) * (scale.isolines + 1)), scale.isolines);
}

Image<float> false_colour(const Image<float>& values, const FalseColour& scale, int channel) {
  require(channel >= 0 && channel < values.channels(), "there is no such channel to colour");
  Image<float> colours(values.width(), values.height(), 3);
  parallel_for(
      values.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        const auto band = [&](int x, int line) {
          return isoline_band(values(x, line, channel), scale);
        };
        for (int x = 0; x < values.width(); ++x) {
          const bool line = scale.isolines > 0 && ((x > 0 && band(x - 1, y) != band(x, y)) ||
                                                   (y > 0 && band(x, y - 1) != band(x, y)));
          const Colour colour = line ? line_colour : false_colour(values(x, y, channel), scale);
          std::ranges::copy(colour, colours.pixel(x, y).begin());
        }
      },
      8);
  return colours;
}

Colour distance_colour(double distance, const DistanceColours& scale) {
  if (!std::isfinite(distance)) return false_colour(std::nan(""), {});
  const Colour colour = false_colour(distance, {.low = 0, .high = scale.most > 0 ? scale.most : 1});
  if (scale.lines < 1 || !(scale.most > 0)) return colour;
  const double spacing = scale.most / (scale.lines + 1);
  const double half = std::min(scale.line_width, spacing / 2) / 2;
  const double away = std::abs(std::remainder(distance, spacing));
  if (distance < spacing / 2 || !(half > 0)) return colour;
  // Full in the middle of the line, gone beyond twice its half width.
  const float ink = float(std::clamp(2 - away / half, 0.0, 1.0));
  Colour mixed;
  for (std::size_t c = 0; c < 3; ++c) mixed[c] = colour[c] + ink * (line_colour[c] - colour[c]);
  return mixed;
}

namespace {

template <class ColourOf>
Signal colours_of_all(const Vector& values, const ColourOf& colour_of) {
  Signal colours(values.size(), 3);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Colour colour = colour_of(values[i]);
    colours.row(i) << colour[0], colour[1], colour[2];
  }
  return colours;
}

}  // namespace

Signal distance_colours(const Vector& distances, const DistanceColours& scale) {
  return colours_of_all(distances, [&](double distance) { return distance_colour(distance, scale); });
}

Signal false_colours(const Vector& values, const FalseColour& scale) {
  return colours_of_all(values, [&](double value) { return false_colour(value, scale); });
}

FalseColour scale_of(std::span<const float> values, FalseColour::Map map) {
  FalseColour scale;
  scale.map = map;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const float v : values)
    if (std::isfinite(v)) low = std::min(low, double(v)), high = std::max(high, double(v));
  if (low > high) return scale;
  if (map == FalseColour::Map::diverging)
    high = std::max(std::abs(low), std::abs(high)), low = -high;
  const bool single = low == high;
  scale.low = single ? low - 0.5 : low;
  scale.high = single ? high + 0.5 : high;
  return scale;
}

std::vector<double> round_ticks(double low, double high, int count) {
  std::vector<double> ticks;
  if (!(high > low) || count < 1) return {low};
  const double rough = (high - low) / count, power = std::pow(10, std::floor(std::log10(rough)));
  const double digit = rough / power;
  const double step = power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
  const double slack = 1e-9 * (high - low);
  for (double n = std::ceil((low - slack) / step); n * step <= high + slack; ++n)
    ticks.push_back(n == 0 ? 0.0 : n * step);
  return ticks;
}

Image<float> legend(const FalseColour& scale, const LegendOptions& options) {
  const int s = options.text_scale, line = text_height(s), pad = 4 * s, bar = 10 * s;
  const int head = options.title.empty() ? 0 : line + 2 * pad;
  const int top = pad + head + line / 2, length = options.height - top - pad - line / 2;
  require(s >= 1 && length >= 2 * line, "a legend needs more height than that");
  const std::vector<double> ticks =
      round_ticks(scale.low, scale.high, std::max(2, length / (4 * line)));
  int text = 0;
  for (const double tick : ticks) text = std::max(text, text_width(fmt::format("{:g}", tick), s));
  const int width = std::max(pad + bar + 6 * s + text, pad + text_width(options.title, s)) + pad;

  Image<float> image(width, options.height, 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < width; ++x) {
      const double t = (top + length - 0.5 - y) / length;
      const bool inside = x >= pad && x < pad + bar && y >= top && y < top + length;
      const auto value = [&](double at) { return scale.low + at * (scale.high - scale.low); };
      const bool isoline =
          inside && y > top && scale.isolines > 0 &&
          isoline_band(value(t), scale) != isoline_band(value(t + 1.0 / length), scale);
      const Colour colour = isoline  ? line_colour
                            : inside ? false_colour(value(t), scale)
                                     : options.background;
      std::ranges::copy(colour, image.pixel(x, y).begin());
    }
  draw_text(image, pad, pad, options.title, {options.text, s});
  for (const double tick : ticks) {
    const int y = top + int(std::lround((1 - place_on(scale, tick)) * (length - 1)));
    for (int x = pad + bar; x < pad + bar + 3 * s; ++x)
      for (int row = y - s / 2; row < y - s / 2 + std::max(1, s / 2 * 2 - 1); ++row)
        std::ranges::copy(options.text, image.pixel(x, row).begin());
    draw_text(image, pad + bar + 6 * s, y - 7 * s / 2, fmt::format("{:g}", tick),
              {options.text, s});
  }
  return image;
}

}  // namespace mq
