/// q = p + t·u(p) as a piecewise linear map of the pixels' grid, inverted by drawing its triangles.

#include "mq/flow/forward_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/image/spread.h"

namespace mq {
namespace {

/// Neighbours further apart than this on the way were torn apart, pixels ...
constexpr double longest_step = 2;

/// ... and there is no triangle between them where it would be larger than this.
constexpr double largest_triangle = 16;

/// Of a triangle's weights: pixels on its sides are its own.
constexpr double slack = 1e-6;

void require_field(const Image<float>& field) {
  require(field.channels() == 2 && !field.empty(),
          fmt::format("a field has two values per pixel; found {} x {} pixels with {}",
                      field.width(), field.height(), field.channels()));
}

/// A corner of a triangle on its way.
struct Corner {
  double x, y;  ///< where it is
  float u, v;   ///< its displacement
  float cost;
};

class Canvas {
 public:
  Canvas(int width, int height)
      : result_{Image<float>(width, height, 2), Image<char>(width, height, 1)},
        known_(width, height, 1),
        cost_(width, height, 1, std::numeric_limits<float>::infinity()) {}

  void draw(const std::array<Corner, 3>& c) {
    const double area =
        (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    if (!(area > 0)) return;
    const auto [left, right] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [top, bottom] = std::minmax({c[0].y, c[1].y, c[2].y});
    const double size = std::max(right - left, bottom - top);
    if (!(size <= largest_triangle)) return;
    const bool torn = size > 1 + longest_step;
    const int width = known_.width(), height = known_.height();
    if (right < 0 || bottom < 0 || left > width - 1 || top > height - 1) return;
    const int x0 = std::max(0, int(std::ceil(left - slack))),
              x1 = std::min(width - 1, int(right + slack));
    const int y0 = std::max(0, int(std::ceil(top - slack))),
              y1 = std::min(height - 1, int(bottom + slack));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        std::array<double, 3> w;
        for (int k = 0; k < 3; ++k) {
          const Corner &a = c[std::size_t(k + 1) % 3], &b = c[std::size_t(k + 2) % 3];
          w[std::size_t(k)] = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
        }
        if (std::ranges::min(w) < -slack) continue;
        const auto mixed = [&](float Corner::*value) {
          return float(w[0] * c[0].*value + w[1] * c[1].*value + w[2] * c[2].*value);
        };
        const float cost = mixed(&Corner::cost);
        char& seen = result_.seen(x, y);
        const bool better = torn ? !seen && cost < cost_(x, y) : !seen || cost < cost_(x, y);
        if (!better) continue;
        seen = torn ? 0 : 1;
        known_(x, y) = 1;
        cost_(x, y) = cost;
        result_.field(x, y, 0) = mixed(&Corner::u);
        result_.field(x, y, 1) = mixed(&Corner::v);
      }
  }

  ForwardWarpedField finished() && {
    spread(known_, std::numeric_limits<double>::infinity(), result_.field);
    return std::move(result_);
  }

 private:
  ForwardWarpedField result_;
  Image<char> known_;
  Image<float> cost_;
};

}  // namespace

ForwardWarpedField forward_warp(const Image<float>& displacement, double time,
                                const Image<float>& cost) {
  require_field(displacement);
  const int width = displacement.width(), height = displacement.height();
  require(cost.width() == width && cost.height() == height && cost.channels() == 1,
          fmt::format("a cost for each of {} x {} pixels is wanted; found {} x {} with {}", width,
                      height, cost.width(), cost.height(), cost.channels()));
  const auto corner = [&](int x, int y) {
    const float u = displacement(x, y, 0), v = displacement(x, y, 1);
    return Corner{x + time * u, y + time * v, u, v, cost(x, y)};
  };
  Canvas canvas(width, height);
  // Grids of one row or column have no triangles: their pixels count as squares.
  const auto next = [](const Corner& c, double dx, double dy) {
    Corner other = c;
    other.x += dx, other.y += dy;
    return other;
  };
  for (int y = 0; y < std::max(1, height - 1); ++y)
    for (int x = 0; x < std::max(1, width - 1); ++x) {
      const bool wide = width > 1, high = height > 1;
      const Corner a = corner(x, y);
      const Corner b = wide ? corner(x + 1, y) : next(a, 1, 0);
      const Corner c = high ? corner(x, y + 1) : next(a, 0, 1);
      const Corner d = wide && high ? corner(x + 1, y + 1) : wide ? next(b, 0, 1) : next(c, 1, 0);
      canvas.draw({a, b, c});
      canvas.draw({b, d, c});
    }
  return std::move(canvas).finished();
}

Image<float> completed(Image<float> field) {
  require_field(field);
  Image<char> known(field.width(), field.height(), 1);
  bool any = false, all = true;
  for (int y = 0; y < field.height(); ++y)
    for (int x = 0; x < field.width(); ++x) {
      const bool is = std::isfinite(field(x, y, 0)) && std::isfinite(field(x, y, 1));
      known(x, y) = is ? 1 : 0;
      any = any || is;
      all = all && is;
    }
  require(any, "the flow of no pixel is known");
  if (!all) spread(known, std::numeric_limits<double>::infinity(), field);
  return field;
}

}  // namespace mq
