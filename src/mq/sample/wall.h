#pragma once
/// A wall whose texture comes in tiles: as large as one likes, for what is too large for one picture.

#include <array>
#include <cstdint>
#include <vector>

#include "mq/sample/paint.h"

namespace mq {

struct WallOptions {
  int tiles = 2;            ///< a side, 1 to 10, as many as names of tiles can count
  int texture_size = 1024;  ///< texels a side of each tile; 16 or more
  int squares = 8;          ///< a side of each tile, of two triangles each
  std::uint64_t seed = 1;   ///< of the colours
};

struct Wall {
  Mesh mesh;  ///< `Mesh::textures` counts the tiles, row by row from below
  std::vector<TextureSize> textures;
  std::vector<std::array<int, 2>> tiles;  ///< per texture, its place among texture coordinates
  ColorField colors;
};

/// Squares of unit side, bulging a little, each a chart and a tile of its own, so that seams run between all of them:
/// four texels of gutter are left around each. Equal options give equal bits. Throws `InvalidInput` for options out of
/// range.
Wall make_wall(const WallOptions& options);

}  // namespace mq
