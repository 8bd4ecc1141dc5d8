// Only vertices that are new, and those of the target that are not in the result, have to be asked
// for their distance.

#include "mq/remesh/detail/measure.h"

#include <algorithm>
#include <cmath>

#include "mq/mesh/components.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

DistanceSummary summary(std::vector<double> distances) {
  if (distances.empty()) return {};
  DistanceSummary found;
  for (const double d : distances) found.mean += d;
  found.mean /= double(distances.size());
  const auto at95 = distances.begin() + std::ptrdiff_t(0.95 * double(distances.size() - 1));
  std::ranges::nth_element(distances, at95);
  found.p95 = *at95;
  found.max = std::ranges::max(distances);
  return found;
}

void append_distances(const Mesh& mesh, const std::vector<Vector3>& points,
                      std::vector<double>& distances) {
  if (points.empty()) return;
  for (const ClosestPoint& place : ClosestPointFinder(mesh)(points))
    distances.push_back(std::sqrt(place.squared_distance));
}

/// Of the result's vertices; 1 is put where a vertex of the target is in the result.
DistanceSummary distance_to_target(const Remeshed& result, const Mesh& target,
                                   const std::vector<ClosestPoint>& on_target,
                                   std::vector<char>& there) {
  std::vector<double> distances;
  std::vector<Vector3> asked;
  for (int v = 0; v < result.mesh.vertex_count(); ++v) {
    const int a = result.template_vertices[v], b = result.target_vertices[v];
    if (a >= 0) {
      distances.push_back(std::sqrt(on_target[a].squared_distance));
    } else if (b >= 0 && target.positions[b] == result.mesh.positions[v]) {
      distances.push_back(0);
      there[b] = 1;
    } else {
      asked.push_back(result.mesh.positions[v]);
    }
  }
  append_distances(target, asked, distances);
  return summary(std::move(distances));
}

DistanceSummary distance_from_target(const Remeshed& result, const Mesh& target,
                                     const std::vector<ClosestPoint>& on_template,
                                     const std::vector<char>& there) {
  std::vector<char> used(target.positions.size(), 0);
  for (const Triangle& t : target.triangles)
    for (const int v : t) used[v] = 1;
  const bool unchanged = result.added == 0 && result.removed == 0;
  std::vector<double> distances;
  std::vector<Vector3> asked;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (there[v])
      distances.push_back(0);
    else if (used[v] && unchanged)
      distances.push_back(std::sqrt(on_template[v].squared_distance));
    else if (used[v])
      asked.push_back(target.positions[v]);
  }
  append_distances(result.mesh, asked, distances);
  return summary(std::move(distances));
}

/// Parts of what was added that hang together.
int count_regions(const Remeshed& result) {
  DisjointSets sets(result.mesh.positions.size());
  std::vector<char> added(result.mesh.positions.size(), 0);
  for (int t = 0; t < result.mesh.triangle_count(); ++t) {
    if (result.template_triangles[t] >= 0) continue;
    const auto& [a, b, c] = result.mesh.triangles[t];
    sets.join(a, b), sets.join(b, c);
    added[a] = added[b] = added[c] = 1;
  }
  int regions = 0;
  for (std::size_t v = 0; v < added.size(); ++v) regions += added[v] && sets.root(int(v)) == int(v);
  return regions;
}

/// Components of the template of which nothing is left.
int count_replaced(const Remeshed& result, const Surface& of_template) {
  const std::vector<int> component = triangle_components(of_template);
  std::vector<char> left(component.size(), 0);
  for (const int t : result.template_triangles)
    if (t >= 0) left[component[t]] = 1;
  int replaced = 0;
  for (std::size_t t = 0; t < component.size(); ++t) replaced += component[t] == int(t) && !left[t];
  return replaced;
}

}  // namespace

void measure(Remeshed& result, const Surface& of_template, const Surface& target,
             const std::vector<ClosestPoint>& on_target,
             const std::vector<ClosestPoint>& on_template) {
  result.kept = int(std::ranges::count_if(result.template_triangles, [](int t) { return t >= 0; }));
  result.removed = of_template.triangle_count() - result.kept;
  result.added = result.mesh.triangle_count() - result.kept;
  std::vector<char> there(target.mesh.positions.size(), 0);
  result.to_target = distance_to_target(result, target.mesh, on_target, there);
  result.from_target = distance_from_target(result, target.mesh, on_template, there);
  result.regions = count_regions(result);
  result.replaced_components = count_replaced(result, of_template);
}

}  // namespace mq
