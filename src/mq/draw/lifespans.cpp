// Each triangle is drawn with vertices of its own, so that it has one colour.

#include "mq/draw/lifespans.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "mq/draw/contact_sheet.h"

namespace mq {
namespace {

constexpr int most_in_sheet = 6;

/// The triangles of a mesh, apart; at `points` where they are given.
Surface apart(const Mesh& mesh, const std::vector<Vector2>* uvs) {
  Mesh result;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int first = int(result.positions.size());
    result.triangles.push_back({first, first + 1, first + 2});
    for (int k = 0; k < 3; ++k) {
      if (!uvs) {
        result.positions.push_back(mesh.position(t, k));
        continue;
      }
      const Vector2& uv = (*uvs)[mesh.corner_uvs[t][k]];
      result.positions.emplace_back(uv.x(), uv.y(), 0);
    }
  }
  return make_surface(result, {.kind = WeldOptions::Kind::none});
}

}  // namespace

Colour lifespan_colour(int first, int last, int count) {
  const double share = double(last - first + 1) / count;
  const double middle = 0.5 * (first + last + 1) / count;
  return colour_of(0.72, 0.19 * (1 - share), 25 + 235 * middle);
}

Image<float> draw_lifespans(const EvolvingMesh& evolving, const LifespanAtlas& atlas, int frame,
                            const View& view, int side, const Progress& progress) {
  const Mesh mesh = evolving.mesh(frame);
  const EvolvingSegment& segment = evolving.segments[evolving.frames[frame].segment];
  std::unordered_map<int, Colour> colours;
  for (const AtlasPrism& chart : atlas.charts)
    if (chart.first <= frame && frame <= chart.last)
      for (const int id : chart.triangles)
        colours[id] = lifespan_colour(chart.first, chart.last, int(evolving.frames.size()));
  std::vector<float> values;
  for (const int id : segment.triangle_ids) {
    const auto found = colours.find(id);
    const Colour colour = found == colours.end() ? Colour{0.7f, 0.7f, 0.7f} : found->second;
    for (int k = 0; k < 3; ++k) values.insert(values.end(), colour.begin(), colour.end());
  }
  RenderOptions options{.view = view, .width = side, .height = side};
  options.paint = RenderOptions::Paint::vertex_colours;
  options.samples = 2;
  const Surface surface = apart(mesh, nullptr);
  const Image<float> model =
      Renderer(surface).draw({.vertex_values = values}, options, progress.step("surface", 0.5));
  options.view = parse_view("front");
  options.view.projection = View::Projection::orthographic;
  options.view.target = Vector3(0.5, 0.5, 0);
  options.view.extent = 1.02;
  options.light = RenderOptions::Light::none;
  const Surface flat = apart(mesh, &mesh.uvs);
  const Image<float> texture =
      Renderer(flat).draw({.vertex_values = values}, options, progress.step("texture", 0.5));
  return contact_sheet({{model, ""}, {texture, ""}}, {.columns = 2, .gap = 4});
}

Image<float> draw_lifespan_sheet(const EvolvingMesh& evolving, const LifespanAtlas& atlas,
                                 const View& view, int side, const Progress& progress) {
  const int count = int(evolving.frames.size()), shown = std::min(count, most_in_sheet);
  std::vector<Tile> tiles;
  for (int i = 0; i < shown; ++i) {
    const int frame = shown == 1 ? 0 : int(std::int64_t(i) * (count - 1) / (shown - 1));
    tiles.push_back(
        {draw_lifespans(evolving, atlas, frame, view, side, progress.step("draw", 1.0 / shown)),
         fmt::format("frame {}", evolving.frames[frame].number)});
  }
  return contact_sheet(tiles, {.columns = 2});
}

}  // namespace mq
