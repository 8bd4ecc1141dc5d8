#include "mq/io/tiles.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace mq {
namespace {

constexpr std::string_view udim_pattern = "<UDIM>";
constexpr std::string_view mari_pattern = "<UVTILE>";
constexpr int first_udim = 1001;
constexpr int udim_columns = 10;

bool parts(char c) { return c == '.' || c == '_' || c == '-'; }

std::optional<int> number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty() || text[0] == '-')
    return std::nullopt;
  return value;
}

TileName named(TileName::Count count, std::string_view name, std::size_t begin, std::size_t size,
               std::optional<TilePlace> place) {
  return {count, std::string(name.substr(0, begin)), std::string(name.substr(begin + size)), place};
}

/// "skin.1001.png": the last four characters of the stem.
std::optional<TileName> udim_name(std::string_view name, std::size_t file, std::size_t stem_end) {
  if (stem_end < file + 5 || !parts(name[stem_end - 5])) return std::nullopt;
  const auto value = number(name.substr(stem_end - 4, 4));
  if (!value || *value < first_udim || *value > 1999) return std::nullopt;
  const int tile = *value - first_udim;
  return named(TileName::Count::udim, name, stem_end - 4, 4,
               TilePlace{tile % udim_columns, tile / udim_columns});
}

/// "skin_u1_v1.png": the end of the stem.
std::optional<TileName> mari_name(std::string_view name, std::size_t file, std::size_t stem_end) {
  const std::string_view stem = name.substr(0, stem_end);
  const std::size_t v = stem.rfind("_v");
  if (v == stem.npos || v < file) return std::nullopt;
  const std::size_t u = stem.rfind('u', v);
  if (u == stem.npos || u <= file || !parts(stem[u - 1])) return std::nullopt;
  const auto column = number(stem.substr(u + 1, v - u - 1)), row = number(stem.substr(v + 2));
  if (!column || !row || *column < 1 || *row < 1) return std::nullopt;
  return named(TileName::Count::mari, name, u, stem_end - u, TilePlace{*column - 1, *row - 1});
}

}  // namespace

bool TileName::has_number_for(const TilePlace& tile) const {
  if (tile.u < 0 || tile.v < 0) return false;
  return count == Count::mari || (tile.u < udim_columns && tile.v <= 99);
}

std::string tile_number(const TileName& name, const TilePlace& tile) {
  return name.count == TileName::Count::mari
             ? fmt::format("u{}_v{}", tile.u + 1, tile.v + 1)
             : std::to_string(first_udim + tile.u + udim_columns * tile.v);
}

std::string TileName::file(const TilePlace& tile) const {
  return before + tile_number(*this, tile) + after;
}

std::string TileName::pattern() const {
  return before + std::string(count == Count::mari ? mari_pattern : udim_pattern) + after;
}

bool TileName::same_pattern(const TileName& other) const {
  return count == other.count && before == other.before && after == other.after;
}

std::optional<TileName> tile_name(std::string_view name) {
  const std::size_t slash = name.find_last_of("/\\");
  const std::size_t file = slash == name.npos ? 0 : slash + 1;
  if (const std::size_t at = name.find(udim_pattern, file); at != name.npos)
    return named(TileName::Count::udim, name, at, udim_pattern.size(), std::nullopt);
  if (const std::size_t at = name.find(mari_pattern, file); at != name.npos)
    return named(TileName::Count::mari, name, at, mari_pattern.size(), std::nullopt);
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos || dot < file) return std::nullopt;
  if (auto found = udim_name(name, file, dot)) return found;
  return mari_name(name, file, dot);
}

std::string common_pattern(const std::vector<std::string>& names) {
  std::optional<TileName> first;
  for (const std::string& name : names) {
    const std::optional<TileName> tile = tile_name(name);
    if (!tile || (first && !first->same_pattern(*tile))) return "";
    if (!first) first = tile;
  }
  return first ? first->pattern() : "";
}

std::optional<TilePlace> tile_of(const Mesh& mesh, int triangle) {
  constexpr double beyond = 1e6;
  if (!mesh.textured(triangle)) return std::nullopt;
  Vector2 middle(0, 0);
  for (int k = 0; k < 3; ++k) {
    const Vector2& uv = mesh.uv(triangle, k);
    if (!(uv.cwiseAbs().maxCoeff() < beyond) || !uv.allFinite()) return std::nullopt;
    middle += uv / 3;
  }
  return TilePlace{int(std::floor(middle.x())), int(std::floor(middle.y()))};
}

}  // namespace mq
