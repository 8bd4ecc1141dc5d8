#include "mq/draw/flow_colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/detail/text.h"

namespace mq {
namespace {

/// From one pure colour to the next; `parts` of the whole circle's sum.
struct Arc {
  Colour from, to;
  double parts;
};
constexpr std::array<Arc, 6> circle = {{{{1, 0, 0}, {1, 1, 0}, 15},
                                        {{1, 1, 0}, {0, 1, 0}, 6},
                                        {{0, 1, 0}, {0, 1, 1}, 4},
                                        {{0, 1, 1}, {0, 0, 1}, 11},
                                        {{0, 0, 1}, {1, 0, 1}, 13},
                                        {{1, 0, 1}, {1, 0, 0}, 6}}};
constexpr double all_parts = 55;

/// Beyond the longest shown everything is this much darker.
constexpr float beyond = 0.75F;

/// Of a place on the circle, 0 to 1.
Colour hue(double turn) {
  double at = turn * all_parts;
  for (const Arc& arc : circle) {
    if (at <= arc.parts) {
      Colour colour;
      for (int c = 0; c < 3; ++c)
        colour[c] = float(arc.from[c] + at / arc.parts * (arc.to[c] - arc.from[c]));
      return colour;
    }
    at -= arc.parts;
  }
  return circle.front().from;
}

void put(Image<float>& image, int x, int y, const Colour& colour) {
  std::ranges::copy(colour, image.pixel(x, y).begin());
}

constexpr Colour page = {0.96F, 0.96F, 0.965F};

}  // namespace

Colour flow_colour(double right, double down) {
  const double length = std::hypot(right, down);
  double turn = std::atan2(down, right) / (2 * std::numbers::pi);
  if (turn < 0) turn += 1;
  Colour colour = hue(turn);
  for (float& part : colour) part = length <= 1 ? float(1 - length * (1 - part)) : beyond * part;
  return colour;
}

double longest(const Image<float>& field) {
  require(field.channels() == 2, "a field has two values per pixel");
  double most = 0;
  for (std::size_t i = 0; i < field.values().size(); i += 2) {
    const double length = std::hypot(double(field.values()[i]), double(field.values()[i + 1]));
    if (std::isfinite(length)) most = std::max(most, length);
  }
  return most;
}

Image<float> flow_picture(const Image<float>& field, double longest) {
  require(field.channels() == 2, "a field has two values per pixel");
  // Rounding must not darken the longest.
  const double scale = longest > 0 ? (1 - 1e-6) / longest : 0;
  Image<float> picture(field.width(), field.height(), 3);
  parallel_for(
      field.height(),
      [&](std::int64_t row) {
        for (int x = 0; x < field.width(); ++x) {
          const double u = field(x, int(row), 0), v = field(x, int(row), 1);
          const bool known = std::isfinite(u) && std::isfinite(v);
          put(picture, x, int(row), known ? flow_colour(scale * u, scale * v) : Colour{0, 0, 0});
        }
      },
      8);
  return picture;
}

Image<float> flow_wheel(double longest, const std::string& unit, int side) {
  const int scale = side >= 240 ? 3 : side >= 120 ? 2 : 1;
  const std::string label = fmt::format("{:.3g} {}", longest, unit);
  const int pad = 4 * scale, width = std::max(side, text_width(label, scale) + 2 * pad);
  Image<float> image(width, side + text_height(scale) + pad, 3);
  const double radius = side / 2.0 - pad, centre_x = width / 2.0, centre_y = side / 2.0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < width; ++x) {
      const double right = (x + 0.5 - centre_x) / radius, down = (y + 0.5 - centre_y) / radius;
      // The rim's pixels are mixed by how much of them lies inside.
      const double inside = std::clamp((1 - std::hypot(right, down)) * radius + 0.5, 0.0, 1.0);
      const double pull = std::min(1.0, 1 / std::max(1e-9, std::hypot(right, down)));
      const Colour colour = flow_colour(pull * right, pull * down);
      Colour mixed;
      for (int c = 0; c < 3; ++c) mixed[c] = float(page[c] + inside * (colour[c] - page[c]));
      put(image, x, y, mixed);
    }
  draw_text(image, width / 2, side, label, {.scale = scale, .anchor = TextStyle::Anchor::centre});
  return image;
}

Image<float> flow_picture_with_wheel(const Image<float>& field, double longest) {
  const Image<float> picture = flow_picture(field, longest);
  const Image<float> wheel =
      flow_wheel(longest, "px", std::clamp(std::max(field.width(), field.height()) / 4, 80, 320));
  Image<float> both(picture.width() + wheel.width(), std::max(picture.height(), wheel.height()), 3);
  for (int y = 0; y < both.height(); ++y)
    for (int x = 0; x < both.width(); ++x) {
      const int at = x - picture.width();
      Colour colour = page;
      if (at < 0 && y < picture.height())
        std::ranges::copy(picture.pixel(x, y), colour.begin());
      else if (at >= 0 && y < wheel.height())
        std::ranges::copy(wheel.pixel(at, y), colour.begin());
      put(both, x, y, colour);
    }
  return both;
}

}  // namespace mq
