#pragma once
/// A flat strip whose pieces lie in the texture wherever a test wants them: over one another,
/// within a texel of one another, around the texture's borders.

#include <functional>
#include <map>
#include <tuple>

#include "atlas/atlas_fixtures.h"

namespace mq::fixtures {

struct StripOptions {
  double length = 2, width = 0.25;
  int cells = 32, cells_up = 4;
  TextureSize size = {64, 64};
  /// Texel coordinates (column and row, of TexelPoint) of a point of a piece ...
  std::function<Vector2(int piece, const Vector2& point)> place;
  /// ... and which piece a quad belongs to, by its middle.
  std::function<int(const Vector2& middle)> piece = [](const Vector2&) { return 0; };
};

/// The strip [0, length] × [0, width] in the xy-plane.
inline Mesh laid_strip(const StripOptions& options) {
  Mesh mesh;
  const auto point = [&](int i, int j) {
    return Vector2(options.length * i / options.cells, options.width * j / options.cells_up);
  };
  for (int j = 0; j <= options.cells_up; ++j)
    for (int i = 0; i <= options.cells; ++i)
      mesh.positions.emplace_back(point(i, j).x(), point(i, j).y(), 0);
  std::map<std::tuple<int, int, int>, int> uvs;
  for (int j = 0; j < options.cells_up; ++j)
    for (int i = 0; i < options.cells; ++i) {
      const int piece = options.piece((point(i, j) + point(i + 1, j + 1)) / 2);
      const auto corner = [&](int a, int b) {
        const auto [at, is_new] = uvs.try_emplace({piece, i + a, j + b}, int(mesh.uvs.size()));
        if (is_new) {
          const Vector2 p = options.place(piece, point(i + a, j + b));
          mesh.uvs.emplace_back((p.x() + 0.5) / options.size.width,
                                1 - (p.y() + 0.5) / options.size.height);
        }
        return at->second;
      };
      const auto vertex = [&](int a, int b) { return (j + b) * (options.cells + 1) + i + a; };
      mesh.triangles.push_back({vertex(0, 0), vertex(1, 0), vertex(1, 1)});
      mesh.triangles.push_back({vertex(0, 0), vertex(1, 1), vertex(0, 1)});
      mesh.corner_uvs.push_back({corner(0, 0), corner(1, 0), corner(1, 1)});
      mesh.corner_uvs.push_back({corner(0, 0), corner(1, 1), corner(0, 1)});
    }
  return mesh;
}

/// Cut across in the middle; the halves, 40 texels long, lie side by side with this much between
/// them (which is that many rows) and the second shifted along by a third of a texel.
inline StripOptions two_halves(double gap) {
  StripOptions options;
  options.piece = [](const Vector2& middle) { return middle.x() < 1 ? 0 : 1; };
  options.place = [gap](int piece, const Vector2& p) {
    return piece == 0 ? Vector2(4.2 + 40 * p.x(), 20.3 - 40 * p.y())
                      : Vector2(4.2 + 1.0 / 3 + 40 * (p.x() - 1), 30.3 + gap - 40 * p.y());
  };
  return options;
}

/// One chart, bent back on itself: its ends, 36 texels long, lie side by side with this much
/// between them.
inline StripOptions bent_back(double gap) {
  StripOptions options;
  options.cells = 80;
  options.place = [gap](int, const Vector2& p) {
    constexpr double texels = 40, straight = 0.9;
    const double radius = gap / 2 + texels * (0.25 - p.y());
    if (p.x() <= straight) return Vector2(4 + texels * p.x(), 30 + radius);
    if (p.x() >= 2 - straight) return Vector2(4 + texels * (2 - p.x()), 30 - radius);
    const double angle = std::numbers::pi * (p.x() - straight) / (2 - 2 * straight);
    return Vector2(4 + texels * straight + radius * std::sin(angle), 30 + radius * std::cos(angle));
  };
  return options;
}

/// One chart that runs twice over the same texels, around the border of a texture that repeats.
inline StripOptions around_twice() {
  StripOptions options;
  options.size = {40, 32, Wrap::repeat};
  options.place = [](int, const Vector2& p) {
    return Vector2(4.2 + 40 * p.x(), 20.3 - 40 * p.y());
  };
  return options;
}

}  // namespace mq::fixtures
