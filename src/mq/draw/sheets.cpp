#include "mq/draw/sheets.h"

#include <algorithm>

#include "mq/base/error.h"

namespace mq {
namespace {

RenderOptions seen_from(const RenderOptions& options, const std::string& name) {
  RenderOptions one = options;
  const View view = parse_view(name);
  one.view.azimuth = view.azimuth, one.view.elevation = view.elevation;
  return one;
}

}  // namespace

Image<float> draw_views(const Renderer& renderer, const Paints& paints,
                        const std::vector<std::string>& views, const RenderOptions& options,
                        const SheetOptions& sheet, const Progress& progress) {
  require(!views.empty(), "no view is given: name at least one");
  std::vector<Tile> tiles;
  for (const std::string& name : views)
    tiles.push_back({renderer.draw(paints, seen_from(options, name),
                                   progress.step(name, 1.0 / double(views.size()))),
                     name});
  return contact_sheet(tiles, sheet);
}

Image<float> draw_versions(const Renderer& renderer, std::span<const Version> versions,
                           const std::vector<std::string>& views, const RenderOptions& options,
                           const SheetOptions& sheet, const Progress& progress) {
  require(!versions.empty(), "no version is given: name at least one");
  const double share = 1 / double(std::max<std::size_t>(1, views.size()) * versions.size());
  std::vector<Tile> tiles;
  const auto add = [&](const RenderOptions& one, const std::string& before_label) {
    for (const Version& version : versions) {
      const std::string label = before_label + version.label;
      tiles.push_back({renderer.draw(version.paints, one, progress.step(label, share)), label});
    }
  };
  if (views.empty()) add(options, "");
  for (const std::string& name : views) add(seen_from(options, name), name + ", ");
  SheetOptions rows = sheet;
  if (rows.columns == 0) rows.columns = int(versions.size());
  return contact_sheet(tiles, rows);
}

Sight sight_of_worst_seam(const Renderer& renderer, const Atlas& atlas, const SeamDifference& seams,
                          double texels, View::Up up) {
  require(!seams.edges.empty(), "there is no seam to look at");
  require(texels > 0, "a view of a seam is more than 0 texels across");
  const double extent = texels * atlas.texel_spacing();
  Sight best = renderer.sight_of(seams.edges.front().point, seams.edges.front().normal, extent, up);
  std::vector<std::pair<double, const SeamPlace*>> views;  // what is shown in each
  for (const SeamPlace& place : seams.edges) {
    double shown = 0;
    for (const SeamPlace& other : seams.edges)
      if ((other.point - place.point).norm() < extent / 2) shown += other.shown;
    views.emplace_back(shown, &place);
  }
  std::ranges::stable_sort(views, std::ranges::greater(), [](const auto& view) { return view.first; });
  double most = 0;
  for (const auto& [shown, place] : views) {
    if (shown <= most) break;
    const Sight sight = renderer.sight_of(place->point, place->normal, extent, up);
    if (!sight.clear || shown * sight.open * sight.open <= most) continue;
    most = shown * sight.open * sight.open;
    best = sight;
  }
  return best;
}

}  // namespace mq
