#pragma once
/// Which pictures of a model come in tiles, and which tiles its triangles need.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/tiles.h"

namespace mq {

/// A picture that stands for one of the model, tiles of one picture together.
struct GivenPicture {
  std::filesystem::path path;                         ///< the first that was named
  std::map<TilePlace, std::filesystem::path> places;  ///< those named one by one
};

/// Pictures as they were given for `wanted` of the model: tiles of one pattern become one picture,
/// unless there is already one for each.
std::vector<GivenPicture> joined_tiles(const std::vector<std::filesystem::path>& given,
                                       std::size_t wanted);

/// The tiles that triangles of a picture lie in, and how many do; of all triangles where `picture` is
/// negative. Triangles without texture coordinates, or with such as no tile has, do not count.
std::map<TilePlace, int> tiles_used(const Mesh& mesh, int picture);

/// The tiles that a picture of this name is read in; none: it is one picture that repeats. A pattern
/// always has tiles; a name with a number has them where triangles lie in several tiles, or in another
/// than the first of which it has the number. Throws `InvalidInput` naming `file` where a pattern has no
/// number for a tile.
std::vector<TilePlace> tiles_of_picture(const TileName& name, const std::map<TilePlace, int>& used,
                                        const std::string& file);

}  // namespace mq
