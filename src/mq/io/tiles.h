#pragma once
/// Pictures in tiles: one picture of a model as several files, each for a unit square of texture
/// coordinates, their numbers in their names.
///
/// Two ways to count. UDIM: 1001 + u + 10 v, as in "skin.1001.png" (u from 0 to 9, v from 0). Mari:
/// "skin_u1_v1.png", both from 1. In place of the number a pattern holds `<UDIM>` or `<UVTILE>`.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// A square of texture coordinates by its lower left corner.
struct TilePlace {
  int u = 0;
  int v = 0;
  auto operator<=>(const TilePlace&) const = default;
};

/// A name with a tile's number or the place for one.
struct TileName {
  enum class Count { udim, mari } count = Count::udim;
  std::string before, after;       ///< what stands around the number
  std::optional<TilePlace> place;  ///< nothing: a pattern

  /// Whether tiles can be counted so.
  bool has_number_for(const TilePlace& tile) const;
  /// The name of a tile's file.
  std::string file(const TilePlace& tile) const;
  /// The name with `<UDIM>` or `<UVTILE>`.
  std::string pattern() const;
  bool same_pattern(const TileName& other) const;
};

/// What a file name says about tiles: a pattern; a number 1001 to 1999 that is all between '.', '_' or
/// '-' and the extension, or u1_v1 there. Only the last part of a path is looked at.
std::optional<TileName> tile_name(std::string_view name);

/// The pattern that all these names fit; empty: there is none.
std::string common_pattern(const std::vector<std::string>& names);

/// "1002", or "u2_v1".
std::string tile_number(const TileName& name, const TilePlace& tile);

/// The tile a triangle lies in, by the middle of its corners; nothing where a corner has no texture
/// coordinates, or such as are not finite or beyond 1e6.
std::optional<TilePlace> tile_of(const Mesh& mesh, int triangle);

}  // namespace mq
