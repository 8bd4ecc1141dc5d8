#include "options/source_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/words.h"

namespace mq::app {
void refuse_texel(const TexturedModel& scene, const std::string& text) {
  throw InvalidInput(
      fmt::format("--from {}: no chart of {} uses such a texel (columns count from the left, rows "
                  "from the top, both from 0, in whole numbers)",
                  text, scene.model.path.string()));
}

namespace {

struct Place {
  enum class Kind { point, texel, vertex } kind = Kind::point;
  std::vector<double> numbers;
  int texture = 0;
};

/// x,y,z or texel,column,row or texelK,column,row or vertex,N.
std::optional<Place> parse_place(const std::string& text) {
  const std::size_t comma = text.find(',');
  const std::string word = text.substr(0, comma);
  const auto rest = [&](std::size_t count) {
    return comma == std::string::npos ? std::nullopt : parse_numbers(text.substr(comma + 1), count);
  };
  Place place;
  std::optional<std::vector<double>> numbers;
  if (word == "vertex") {
    place.kind = Place::Kind::vertex;
    numbers = rest(1);
  } else if (word.starts_with("texel")) {
    place.kind = Place::Kind::texel;
    const auto texture = word == "texel" ? std::vector{0.0} : parse_numbers(word.substr(5), 1);
    if (!texture || !(texture->front() >= 0 && texture->front() < 1e6)) return std::nullopt;
    place.texture = int(texture->front());
    numbers = rest(2);
  } else {
    numbers = parse_numbers(text, 3);
  }
  if (!numbers) return std::nullopt;
  place.numbers = *numbers;
  return place;
}

/// The closest point of the surface.
SourcePlace on_surface(Run& run, const TexturedModel& scene, const std::string& text, const Vector3& point,
                       const ClosestPointFinder* finder) {
  const ClosestPoint closest =
      finder != nullptr ? (*finder)(point) : ClosestPointFinder(scene.surface.mesh)(point);
  require(closest.triangle >= 0 && std::isfinite(closest.squared_distance),
          fmt::format("--from {}: so far away from the surface that it is no place on it; name one near it", text));
  require(works_at_vertices(run.options(), scene) || scene.atlas->chart[closest.triangle] >= 0,
          fmt::format("--from {}: the surface there (triangle {}) has no texture coordinates or no "
                      "area in the texture; give another place, or --vertices",
                      text, closest.triangle));
  const double away = std::sqrt(closest.squared_distance);
  if (away > 0.01 * std::sqrt(scene.surface.area))
    run.terminal().warning(
        fmt::format("--from {}: {:.3g} away from the surface; its closest point "
                    "is taken",
                    text, away));
  return {.text = text, .on_surface = closest};
}

/// In textures a vertex is a place: that of any of its corners.
SourcePlace at_vertex(const Run& run, const TexturedModel& scene, const std::string& text, double number) {
  const int count = scene.model.mesh.vertex_count();
  require(number >= 0 && number < count && number == std::floor(number),
          fmt::format("--from {}: {} has the vertices 0, 1, ... {}", text,
                      scene.model.path.string(), count - 1));
  const int vertex = scene.surface.vertex_from_source[std::size_t(number)];
  require(vertex >= 0, fmt::format("--from {}: no triangle uses this vertex", text));
  if (works_at_vertices(run.options(), scene)) return {.text = text, .vertex = vertex};
  const Mesh& mesh = scene.surface.mesh;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      if (mesh.triangles[t][k] == vertex && scene.atlas->chart[t] >= 0 &&
          !scene.surface.degenerate[t])
        return {.text = text,
                .on_surface = SurfacePoint{t, Vector3::Unit(k)}};
  throw InvalidInput(fmt::format(
      "--from {}: no triangle there has texture coordinates; give another place, or --vertices",
      text));
}

SourcePlace at_texel(const Run& run, const TexturedModel& scene, const std::string& text,
                     const Place& place) {
  require(!works_at_vertices(run.options(), scene),
          "--from " + text + ": at vertices there are no texels; give a place, x,y,z");
  const auto textures = scene.texture_sizes.size();
  require(std::size_t(place.texture) < textures,
          fmt::format("--from {}: {} has {}, counted from 0", text, scene.model.path.string(),
                      counted(std::int64_t(textures), "texture")));
  const TextureSize size = scene.texture_sizes[std::size_t(place.texture)];
  const double x = place.numbers[0], y = place.numbers[1];
  if (!(x >= 0 && x < size.width && x == std::floor(x) && y >= 0 && y < size.height &&
        y == std::floor(y)))
    refuse_texel(scene, text);
  return {.text = text, .texel = Texels::Place{place.texture, int(x), int(y)}};
}

}  // namespace

void add_source_options(OptionTable& table) {
  table.add({.name = "from",
             .type = Option::Type::text,
             .count = Option::Count::many,
             .accepts = [](const std::string& text) { return parse_place(text).has_value(); },
             .wanted = "x,y,z or texel,column,row or vertex,number",
             .metavar = "PLACE",
             .group = "Distance",
             .help = "a source: x,y,z in space, texel,column,row or vertex,number",
             .details = "Given several times, distances are to the nearest. A place in space means "
                        "the closest point of the surface. texel2,... is in the texture of number "
                        "2 (from 0)."});
  table.add({.name = "from-mask",
             .type = Option::Type::path,
             .count = Option::Count::many,
             .group = "Distance",
             .help = "sources are the texels that this picture shows brighter than half",
             .details = "One picture for each texture, of its size, in their order."});
}

std::vector<SourcePlace> source_places(Run& run, const TexturedModel& scene,
                                       const ClosestPointFinder* closest) {
  const OptionValues& options = run.options();
  std::vector<SourcePlace> places;
  for (const std::string& text : options.texts("from")) {
    const Place place = *parse_place(text);
    const std::vector<double>& n = place.numbers;
    places.push_back(place.kind == Place::Kind::texel ? at_texel(run, scene, text, place)
                     : place.kind == Place::Kind::vertex
                         ? at_vertex(run, scene, text, n[0])
                         : on_surface(run, scene, text, {n[0], n[1], n[2]}, closest));
  }
  const std::vector<std::string> masks = options.texts("from-mask");
  if (!masks.empty() && works_at_vertices(run.options(), scene))
    throw InvalidInput(masks.front() + ": --from-mask is for textures; use --from");
  return places;
}

std::vector<GeodesicSource> sources_at(const Run& run, const TexturedModel& scene, const ModelSignal& domain,
                                       std::span<const SourcePlace> places) {
  std::vector<GeodesicSource> sources;
  for (const SourcePlace& place : places) {
    if (place.texel) {
      const std::vector<GeodesicSource> found = sources_at_texel(domain, *place.texel);
      if (found.empty()) refuse_texel(scene, place.text);
      std::ranges::copy(found, std::back_inserter(sources));
    } else if (place.on_surface) {
      std::ranges::copy(sources_at_point(scene, domain, *place.on_surface),
                        std::back_inserter(sources));
    } else {
      sources.push_back({place.vertex, 0, scene.surface.mesh.positions[std::size_t(place.vertex)]});
    }
  }
  const std::vector<std::string> masks = run.options().texts("from-mask");
  if (masks.empty()) return sources;
  std::vector<Image<float>> pictures;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    pictures.push_back(read_texture(masks[i]).pixels);
    require_size(masks[i], pictures[i].width(), pictures[i].height(), scene, i);
  }
  const std::vector<GeodesicSource> found = sources_in_masks(domain, pictures);
  require(!found.empty(),
          masks.front() + ": --from-mask: no texel of a chart is brighter than half in it");
  std::ranges::copy(found, std::back_inserter(sources));
  return sources;
}

}  // namespace mq::app
