// Seeds: the vertices of either surface that do not show the other, and the components that show
// one another.

#include "mq/remesh/detail/remesher.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"
#include "mq/remesh/detail/measure.h"
#include "mq/remesh/detail/retriangulate.h"
#include "mq/remesh/detail/score.h"

namespace mq {
namespace {

constexpr double shown_in_tolerances = 0.2;  // or in farthest: nearer than that, renewed

}  // namespace

void Remesher::find_seeds(const Progress& progress) {
  Stopwatch watch;
  const double h = mean_edge_length(template_), g = mean_edge_length(target_);
  const double tolerance = options_.tolerance > 0 ? options_.tolerance : 2 * std::min(h, g);
  reach_ = 2 * tolerance + 2 * (h + g);
  const double accuracy = options_.accuracy > 0 ? options_.accuracy : tolerance;
  const MismatchOptions how{accuracy, options_.occlusion, options_.curvature, options_.keep,
                            options_.farthest};
  Mismatch of_template = mismatch(template_, target_finder_, how, progress.step("template", 0.5));
  Mismatch of_target = mismatch(target_, template_finder_, how, progress.step("target", 0.5));
  distorted_.assign(options_.retriangulated.begin(), options_.retriangulated.end());
  if (!options_.rest.empty()) {
    const std::vector<char> distorted = distorted_triangles(template_.mesh, options_.rest);
    distorted_.resize(distorted.size(), 0);
    for (std::size_t t = 0; t < distorted.size(); ++t) distorted_[t] |= distorted[t];
  }
  result_.distorted = int(std::ranges::count(distorted_, char(1)));
  const double near = shown_in_tolerances *
                      std::min(tolerance, options_.farthest > 0 ? options_.farthest : tolerance);
  for (std::size_t t = 0; t < distorted_.size(); ++t) {
    const Triangle& corners = template_.mesh.triangles[t];
    if (distorted_[t] && std::ranges::any_of(corners, [&](int v) {
          return of_template.places[v].squared_distance > near * near;
        }))
      for (const int v : corners) of_template.scores[v] = std::max(of_template.scores[v], 2.0);
  }
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
