#include "mq/remesh/detail/seeds.h"

#include <algorithm>

#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr double shown_in_tolerances = 0.2;  // or in farthest: nearer than that, renewed

/// Vertices that are left are not seeds, nor do seeds spread to them.
void leave(std::span<const char> left, std::vector<double>& scores) {
  for (std::size_t v = 0; v < left.size(); ++v)
    if (left[v]) scores[v] = 0;
}

}  // namespace

SeedScores seed_scores(const SearchedSurface& of_template, const SearchedSurface& target,
                       const RemeshOptions& options, const Progress& progress) {
  SeedScores found;
  const double h = mean_edge_length(of_template.surface), g = mean_edge_length(target.surface);
  found.tolerance = options.tolerance > 0 ? options.tolerance : 2 * std::min(h, g);
  const double accuracy = options.accuracy > 0 ? options.accuracy : found.tolerance;
  MismatchOptions how{accuracy, options.occlusion, options.curvature, options.keep,
                      options.farthest, of_template.places};
  found.of_template =
      mismatch(of_template.surface, target.closest, how, progress.step("template", 0.5));
  how.places = target.places;
  found.of_target =
      mismatch(target.surface, of_template.closest, how, progress.step("target", 0.5));
  found.distorted.assign(options.retriangulated.begin(), options.retriangulated.end());
  if (!options.rest.empty()) {
    const std::vector<char> distorted =
        distorted_triangles(of_template.surface.mesh, options.rest);
    found.distorted.resize(distorted.size(), 0);
    for (std::size_t t = 0; t < distorted.size(); ++t) found.distorted[t] |= distorted[t];
  }
  const double near =
      shown_in_tolerances *
      std::min(found.tolerance, options.farthest > 0 ? options.farthest : found.tolerance);
  std::vector<double>& scores = found.of_template.scores;
  for (std::size_t t = 0; t < found.distorted.size(); ++t) {
    const Triangle& corners = of_template.surface.mesh.triangles[t];
    if (found.distorted[t] && std::ranges::any_of(corners, [&](int v) {
          return found.of_template.places[v].squared_distance > near * near;
        }))
      for (const int v : corners) scores[v] = std::max(scores[v], 2.0);
  }
  leave(options.left_of_template, scores);
  leave(options.left_of_target, found.of_target.scores);
  return found;
}

}  // namespace mq
