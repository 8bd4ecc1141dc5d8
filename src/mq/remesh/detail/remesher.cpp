// Seeds: the vertices of either surface that do not show the other, and the components that show
// one another.

#include "mq/remesh/detail/remesher.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/mesh/components.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"
#include "mq/remesh/detail/measure.h"
#include "mq/remesh/detail/seeds.h"

namespace mq {

void Remesher::find_seeds(const Progress& progress) {
  Stopwatch watch;
  SeedScores found =
      seed_scores({template_, template_finder_, template_places_}, {target_, target_finder_, target_places_}, options_,
                  progress);
  const double tolerance = found.tolerance;
  reach_ = 2 * tolerance + 2 * (mean_edge_length(template_) + mean_edge_length(target_));
  Mismatch &of_template = found.of_template, &of_target = found.of_target;
  distorted_ = std::move(found.distorted);
  result_.distorted = int(std::ranges::count(distorted_, char(1)));
  const auto above = [](const std::vector<double>& scores) {
    return int(std::ranges::count_if(scores, [](double s) { return s > 1; }));
  };
  result_.tolerance = tolerance;
  result_.template_seeds = above(of_template.scores);
  result_.target_seeds = above(of_target.scores);
  on_target_ = std::move(of_template.places);
  on_template_ = std::move(of_target.places);
  scores_ = std::move(of_template.scores);
  scores_.insert(scores_.end(), of_target.scores.begin(), of_target.scores.end());
  pair_ = join(template_, target_);
  refuse_inside_out();
  group_components();
  note("find seeds", watch);
}

void Remesher::refuse_inside_out() const {
  const std::vector<Vector3> normals = triangle_normals(target_.mesh);
  std::int64_t near = 0, against = 0;
  for (int v = 0; v < template_.mesh.vertex_count(); ++v) {
    if (scores_[v] > 1) continue;
    ++near;
    against += normals[on_target_[v].triangle].dot(pair_.normals[v]) < 0;
  }
  require(
      2 * near < std::ssize(on_target_) || 10 * against <= 9 * near,
      fmt::format("where the template lies at its target, {} of {} of its vertices have normals "
                  "that point the other way: one of the two is turned inside out; turn it over",
                  against, near));
}

/// Components of both surfaces that show one another are one group.
void Remesher::group_components() {
  const std::vector<int> of_template = triangle_components(template_);
  const std::vector<int> of_target = triangle_components(target_);
  const int count = template_.triangle_count();
  DisjointSets sets(std::size_t(count) + of_target.size());
  const auto join_near = [&](const Surface& surface, const std::vector<ClosestPoint>& places,
                             int first_score, auto&& join) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      for (const int v : surface.mesh.triangles[t])
        if (scores_[first_score + v] <= 1) join(t, places[v].triangle);
  };
  join_near(template_, on_target_, 0,
            [&](int t, int s) { sets.join(of_template[t], count + of_target[s]); });
  join_near(target_, on_template_, template_.mesh.vertex_count(),
            [&](int s, int t) { sets.join(of_template[t], count + of_target[s]); });
  for (int t = 0; t < count; ++t) template_group_.push_back(sets.root(of_template[t]));
  for (const int c : of_target) target_group_.push_back(sets.root(count + c));
  replaced_.assign(std::size_t(count) + of_target.size(), 0);
  group_area_.assign(replaced_.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    group_area_[group(t)] += triangle_area(pair_.mesh, t);
}

Remeshed Remesher::run(const Progress& progress) {
  find_seeds(progress.step("find seeds", 0.5));
  Cut cut = grow(progress.step("grow", 0.3));
  Stopwatch watch;
  finish(cut, progress.step("stitch", 0.2));
  return std::move(result_);
}

}  // namespace mq
