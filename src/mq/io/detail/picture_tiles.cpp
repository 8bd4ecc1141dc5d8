#include "mq/io/detail/picture_tiles.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"

namespace mq {

std::vector<GivenPicture> joined_tiles(const std::vector<std::filesystem::path>& given,
                                       std::size_t wanted) {
  std::vector<GivenPicture> pictures;
  for (const std::filesystem::path& path : given) {
    const std::optional<TileName> tile =
        given.size() == wanted && wanted > 1 ? std::nullopt : tile_name(path.string());
    auto found = pictures.end();
    if (tile)
      found = std::ranges::find_if(pictures, [&](const GivenPicture& picture) {
        const auto other = tile_name(picture.path.string());
        return other && other->same_pattern(*tile);
      });
    if (found == pictures.end()) found = pictures.insert(found, GivenPicture{path, {}});
    if (tile && tile->place) found->places[*tile->place] = path;
  }
  return pictures;
}

std::map<TilePlace, int> tiles_used(const Mesh& mesh, int picture) {
  std::map<TilePlace, int> used;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (picture < 0 || mesh.texture(t) == picture)
      if (const std::optional<TilePlace> tile = tile_of(mesh, t)) ++used[*tile];
  return used;
}

std::vector<TilePlace> tiles_of_picture(const TileName& name, const std::map<TilePlace, int>& used,
                                        const std::string& file) {
  const bool pattern = !name.place.has_value();
  const bool other = used.size() == 1 && used.begin()->first != TilePlace{} &&
                     name.place == std::optional(TilePlace{});
  if (!pattern && used.size() < 2 && !other) return {};
  std::vector<TilePlace> tiles;
  for (const auto& [tile, triangles] : used) {
    if (name.has_number_for(tile)) {
      tiles.push_back(tile);
      continue;
    }
    if (!pattern) return {};
    throw InvalidInput(fmt::format(
        "{}: has {} in the tile from ({}, {}), for which {} has no number: move their UVs", file,
        counted(triangles, "triangle"), tile.u, tile.v, name.pattern()));
  }
  if (pattern && tiles.empty()) tiles.push_back({});
  return tiles;
}

}  // namespace mq
