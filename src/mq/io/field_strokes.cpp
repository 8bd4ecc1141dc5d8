#include "mq/io/field_strokes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/json_read.h"

namespace mq {
namespace {

constexpr const char* wanted_strokes = "an object with \"strokes\", a list of objects with \"points\" or \"uv\"";

FieldStroke stroke_of(const JsonObject& json) {
  FieldStroke stroke;
  stroke.place = json.place();
  json.require_only({"points", "uv", "texture", "strength"});
  if (json.has("points") == json.has("uv"))
    throw IoError(fmt::format("{}: found {}, wanted one of \"points\", places in space, and \"uv\", places in a texture",
                              stroke.place, json.has("uv") ? "both" : "neither"));
  const bool flat = json.has("uv");
  const std::vector<double> numbers = flat ? json.rows("uv", 2) : json.rows("points", 3);
  // What an atlas takes (texel_point.h).
  constexpr double most_tiles = 100;
  for (const double number : numbers)
    if (flat && std::abs(number) > most_tiles)
      throw IoError(fmt::format("{}: uv: found {}, wanted coordinates of a texture, {} at most", stroke.place, number, most_tiles));
  const std::size_t count = numbers.size() / (flat ? 2 : 3);
  for (std::size_t i = 0; i < count; ++i)
    if (flat)
      stroke.uvs.emplace_back(numbers[2 * i], numbers[2 * i + 1]);
    else
      stroke.points.emplace_back(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
  if (count < 2)
    throw IoError(fmt::format("{}: found {} point{}, wanted two at least: a stroke goes from one to the next",
                              stroke.place, count, count == 1 ? "" : "s"));
  const auto is_one = [](const auto& places) {
    return std::ranges::all_of(places, [&](const auto& place) { return place == places.front(); });
  };
  if (flat ? is_one(stroke.uvs) : is_one(stroke.points))
    throw IoError(fmt::format("{}: found {} points that are one, wanted a stroke with a length", stroke.place, count));
  if (json.has("texture")) stroke.texture = json.whole("texture", 0, 1 << 20);
  stroke.strength = json.number("strength", 1);
  constexpr double most_strength = 1e6;
  if (!(stroke.strength > 0 && stroke.strength <= most_strength))
    throw IoError(fmt::format("{}: strength: found {}, wanted a number above 0, {} at most", stroke.place, stroke.strength,
                              most_strength));
  return stroke;
}

}  // namespace

std::vector<FieldStroke> read_field_strokes(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  const std::string name = path.string();
  const JsonFile file{name, text_of(bytes), parse_json(name, text_of(bytes), wanted_strokes)};
  const JsonObject root(file, wanted_strokes);
  std::vector<FieldStroke> strokes;
  for (const JsonObject& stroke : root.objects("strokes")) strokes.push_back(stroke_of(stroke));
  if (strokes.empty()) throw IoError(name + ": has no strokes; the smoothest field would be 0 everywhere");
  return strokes;
}

void write_field_strokes(const std::filesystem::path& path, std::span<const FieldStroke> strokes) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const FieldStroke& stroke : strokes) {
    nlohmann::ordered_json json, places = nlohmann::ordered_json::array();
    for (const Vector3& p : stroke.points) places.push_back({p.x(), p.y(), p.z()});
    for (const Vector2& p : stroke.uvs) places.push_back({p.x(), p.y()});
    json[stroke.uvs.empty() ? "points" : "uv"] = std::move(places);
    if (!stroke.uvs.empty()) json["texture"] = stroke.texture;
    json["strength"] = stroke.strength;
    all.push_back(std::move(json));
  }
  write_file(path, to_bytes(nlohmann::ordered_json{{"strokes", std::move(all)}}.dump() + "\n"));
}

}  // namespace mq
