// What the thesis cuts along the sides of voxels is here cut along the level of a distance, and
// what it merges vertex by vertex is here joined by strips: whole triangles on both sides of a gap
// about one edge wide. Nothing has to be intersected, the template's triangles next to the seam
// stay as they are, and a strip between two closed curves is an annulus whatever their shapes, so
// that the result is manifold by construction.

#include "mq/remesh/remesh.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/soundness.h"
#include "mq/remesh/detail/flaws.h"
#include "mq/remesh/detail/remesher.h"
#include "mq/remesh/detail/seeds.h"

namespace mq {
namespace {

void require_area(const Surface& of_template) {
  require(of_template.area > 0, "the template has no triangle with area, so nothing to keep");
}

void check(const Surface& of_template, const Surface& target, const RemeshOptions& options) {
  require_area(of_template);
  require(target.area > 0, "the target has no triangle with area, so nothing to show");
  require(options.tolerance >= 0 && std::isfinite(options.tolerance),
          fmt::format("the tolerance must be a distance, found {}", options.tolerance));
  require(
      options.accuracy >= 0 && std::isfinite(options.accuracy) && options.farthest >= 0,
      fmt::format("the accuracy and the farthest of remeshing must be distances, found {} and {}",
                  options.accuracy, options.farthest));
  require(options.keep >= 0 && options.keep <= 1,
          fmt::format("the score to keep must be from 0 to 1, found {}", options.keep));
  require(options.retriangulated.empty() ||
              std::ssize(options.retriangulated) == of_template.triangle_count(),
          "what is renewed needs an entry per triangle of the template");
  require((options.left_of_template.empty() ||
           std::ssize(options.left_of_template) == of_template.mesh.vertex_count()) &&
              (options.left_of_target.empty() ||
               std::ssize(options.left_of_target) == target.mesh.vertex_count()),
          "what is left needs an entry per vertex");
  require(options.growth >= 0,
          fmt::format("growth must not be negative, found {}", options.growth));
}

}  // namespace

std::vector<std::array<Vector3, 3>> corner_positions(const Mesh& mesh) {
  std::vector<std::array<Vector3, 3>> corners;
  corners.reserve(mesh.triangles.size());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    corners.push_back({mesh.position(t, 0), mesh.position(t, 1), mesh.position(t, 2)});
  return corners;
}

Remeshed remesh(const Surface& of_template, const Surface& target, const RemeshOptions& options,
                const Progress& progress) {
  check(of_template, target, options);
  const ClosestPointFinder on_template(of_template.mesh), on_target(target.mesh);
  return Remesher({of_template, on_template}, {target, on_target}, options).run(progress);
}

Remeshed remesh(const SearchedSurface& of_template, const SearchedSurface& target,
                const RemeshOptions& options, const Progress& progress) {
  check(of_template.surface, target.surface, options);
  return Remesher(of_template, target, options).run(progress);
}

RemeshSeeds remesh_seeds(const SearchedSurface& of_template, const SearchedSurface& target,
                         const RemeshOptions& options, const Progress& progress) {
  check(of_template.surface, target.surface, options);
  SeedScores found = seed_scores(of_template, target, options, progress);
  const auto above = [](const std::vector<double>& scores) {
    std::vector<char> seeds;
    for (const double s : scores) seeds.push_back(s > 1);
    return seeds;
  };
  return {above(found.of_template.scores), above(found.of_target.scores),
          std::move(found.of_target.places)};
}

Remeshed tidied(const Surface& surface, const Progress& progress) {
  require_area(surface);
  const ClosestPointFinder closest(surface.mesh);
  return tidied(SearchedSurface{surface, closest}, progress);
}

Remeshed tidied(const SearchedSurface& searched, const Progress& progress) {
  const Surface& surface = searched.surface;
  std::vector<char> flawed(surface.mesh.triangles.size(), 0);
  for (const int t : folded_triangles(surface)) flawed[t] = 1;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const double longest = longest_edge(surface.mesh, t);
    if (!(2 * triangle_area(surface.mesh, t) > thinnest * longest * longest)) flawed[t] = 1;
  }
  return remesh(searched, searched, {.retriangulated = flawed}, progress);
}

}  // namespace mq
