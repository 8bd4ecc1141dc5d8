#include "mq/sample/wall.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "mq/base/error.h"

namespace mq {
namespace {

constexpr int gutter = 4;  // texels

void require_possible(const WallOptions& options) {
  require(options.tiles >= 1 && options.tiles <= 10,
          fmt::format("a wall of {} tiles a side: wanted 1 to 10, as many as names of tiles can count", options.tiles));
  require(options.texture_size >= 16 && options.texture_size <= 32768,
          fmt::format("tiles of {} texels a side: wanted 16 to 32768", options.texture_size));
  require(options.squares >= 1 && options.squares <= 1000,
          fmt::format("{} squares a side of a tile: wanted 1 to 1000", options.squares));
}

Vector3 place(double x, double y) {
  constexpr double bulge = 0.08;
  const double waves = std::sin(std::numbers::pi * x) * std::sin(std::numbers::pi * y) + std::sin(1.3 * x + y);
  return {x, y, bulge * waves};
}

}  // namespace

Wall make_wall(const WallOptions& options) {
  require_possible(options);
  const int side = options.tiles, k = options.squares, across = side * k + 1;
  Wall wall;
  Mesh& mesh = wall.mesh;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) mesh.positions.push_back(place(double(i) / k, double(j) / k));
  const double first = double(gutter) / options.texture_size, span = 1 - 2 * first;
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < side; ++u) {
      const int base = int(mesh.uvs.size());
      for (int j = 0; j <= k; ++j)
        for (int i = 0; i <= k; ++i) mesh.uvs.emplace_back(u + first + span * i / k, v + first + span * j / k);
      for (int j = 0; j < k; ++j)
        for (int i = 0; i < k; ++i) {
          const int p = (v * k + j) * across + u * k + i, q = base + j * (k + 1) + i;
          mesh.triangles.push_back({p, p + 1, p + across + 1});
          mesh.triangles.push_back({p, p + across + 1, p + across});
          mesh.corner_uvs.push_back({q, q + 1, q + k + 2});
          mesh.corner_uvs.push_back({q, q + k + 2, q + k + 1});
          mesh.textures.insert(mesh.textures.end(), 2, int(wall.tiles.size()));
        }
      wall.tiles.push_back({u, v});
      wall.textures.push_back({options.texture_size, options.texture_size});
    }
  wall.colors = colorful(0.5, options.seed);
  return wall;
}

}  // namespace mq
