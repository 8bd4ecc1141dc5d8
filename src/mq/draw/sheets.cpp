#include "mq/draw/sheets.h"

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

Image<float> draw_before_after(const Renderer& renderer, const Paints& before, const Paints& after,
                               const RenderOptions& options, const Labels& labels,
                               const SheetOptions& sheet, const Progress& progress) {
  const Image<float> left = renderer.draw(before, options, progress.step(labels.before, 0.5));
  const Image<float> right = renderer.draw(after, options, progress.step(labels.after, 0.5));
  SheetOptions side_by_side = sheet;
  if (side_by_side.columns == 0) side_by_side.columns = 2;
  return contact_sheet({{left, labels.before}, {right, labels.after}}, side_by_side);
}

Image<float> draw_views_before_after(const Renderer& renderer, const Paints& before,
                                     const Paints& after, const std::vector<std::string>& views,
                                     const RenderOptions& options, const Labels& labels,
                                     const SheetOptions& sheet, const Progress& progress) {
  require(!views.empty(), "no view is given: name at least one");
  const double share = 0.5 / double(views.size());
  std::vector<Tile> tiles;
  for (const std::string& name : views) {
    const RenderOptions one = seen_from(options, name);
    tiles.push_back(
        {renderer.draw(before, one, progress.step(name, share)), name + ", " + labels.before});
    tiles.push_back(
        {renderer.draw(after, one, progress.step(name, share)), name + ", " + labels.after});
  }
  SheetOptions pairs = sheet;
  if (pairs.columns == 0) pairs.columns = 2;
  return contact_sheet(tiles, pairs);
}

Sight sight_of_worst_seam(const Renderer& renderer, const Atlas& atlas, const SeamDifference& seams,
                          double texels, View::Up up) {
  require(!seams.edges.empty(), "there is no seam to look at");
  require(texels > 0, "a view of a seam is more than 0 texels across");
  const double extent = texels * atlas.texel_spacing();
  Sight best = renderer.sight_of(seams.worst.point, seams.worst.normal, extent, up);
  double most = 0;
  for (const SeamPlace& place : seams.edges) {
    double weight = 0;
    for (const SeamPlace& other : seams.edges)
      if ((other.point - place.point).norm() < extent / 2) weight += other.weight;
    if (weight <= most) continue;
    const Sight sight = renderer.sight_of(place.point, place.normal, extent, up);
    if (!sight.clear || weight * sight.open * sight.open <= most) continue;
    most = weight * sight.open * sight.open;
    best = sight;
  }
  return best;
}

}  // namespace mq
