// A component's χ = V − E + F counts the vertices, edges and triangles that it uses. A surface's vertices have one fan
// each, so that edges of a boundary that share a vertex are of one loop. Triangles that use a vertex twice are no part
// of a fan, and are left out.

#include "mq/baseline/keyframes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/mesh/components.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

bool is_collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Loops of the whole boundary: per vertex the lowest one of its loop, −1 inside.
std::vector<int> boundary_loops(const Surface& surface) {
  DisjointSets sets(surface.mesh.positions.size());
  std::vector<int> loop(surface.mesh.positions.size(), -1);
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
    const Triangle& t = surface.mesh.triangles[h / 3];
    if (surface.twins[h] >= 0 || is_collapsed(t)) continue;
    const int from = t[h % 3], to = t[(h + 1) % 3];
    sets.join(from, to);
    loop[from] = loop[to] = 0;
  }
  for (std::size_t v = 0; v < loop.size(); ++v)
    if (loop[v] == 0) loop[v] = sets.root(int(v));
  return loop;
}

}  // namespace

std::vector<ComponentShape> component_shapes(const Surface& surface, double least_part) {
  const std::vector<int> component = triangle_components(surface);
  const std::vector<int> loop = boundary_loops(surface);
  const std::size_t count = surface.mesh.triangles.size();
  std::vector<double> area(count);
  std::vector<int> euler(count), loops(count);
  std::vector<std::pair<int, int>> uses;  // a component and its vertex
  double whole = 0;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const int c = component[t];
    const double a = triangle_area(surface.mesh, t);
    area[c] += a;
    whole += a;
    ++euler[c];
    for (int k = 0; k < 3; ++k) {
      const HalfEdge h = 3 * t + k;
      euler[c] -= surface.twins[h] < 0 || surface.twins[h] > h;
      uses.emplace_back(c, surface.mesh.triangles[t][k]);
    }
  }
  std::ranges::sort(uses);
  const auto repeated = std::ranges::unique(uses);
  uses.erase(repeated.begin(), repeated.end());
  for (const auto& [c, vertex] : uses) {
    ++euler[c];
    loops[c] += loop[vertex] == vertex;
  }
  std::vector<ComponentShape> shapes;
  for (std::size_t c = 0; c < count; ++c)
    if (area[c] > 0 && area[c] >= least_part * whole) shapes.push_back({(2 - euler[c] - loops[c]) / 2, area[c]});
  std::ranges::stable_sort(shapes, std::ranges::greater{}, &ComponentShape::area);
  return shapes;
}

std::vector<double> keyframe_scores(std::span<const std::vector<ComponentShape>> frames) {
  int most_genus = 0;
  double most_area = 0;
  for (const auto& shapes : frames)
    for (const ComponentShape& shape : shapes) {
      most_genus = std::max(most_genus, shape.genus);
      most_area = std::max(most_area, shape.area);
    }
  std::vector<double> scores;
  for (const auto& shapes : frames) {
    double score = 0;
    for (const ComponentShape& shape : shapes) score += 1 + (most_genus - shape.genus) + shape.area / most_area / 2;
    scores.push_back(score);
  }
  return scores;
}

std::vector<KeyframeRange> choose_keyframes(std::span<const double> scores, const FollowKeyframe& follow) {
  for (const double score : scores) require(std::isfinite(score), "the score of a frame is no finite number");
  const int count = int(scores.size());
  std::vector<int> order(scores.size());
  for (int f = 0; f < count; ++f) order[f] = f;
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](int f) { return scores[f]; });
  std::vector<char> shown(scores.size());
  std::vector<KeyframeRange> ranges;
  for (const int keyframe : order) {
    if (shown[keyframe]) continue;
    int first = keyframe, last = keyframe;
    while (first > 0 && !shown[first - 1]) --first;
    while (last + 1 < count && !shown[last + 1]) ++last;
    const KeyframeRange found = follow(keyframe, first, last);
    require(found.keyframe == keyframe && first <= found.first && found.first <= keyframe && keyframe <= found.last &&
                found.last <= last,
            fmt::format("keyframe {} was to be followed in frames {} to {}: found {} in {} to {}", keyframe, first,
                        last, found.keyframe, found.first, found.last));
    std::fill(shown.begin() + found.first, shown.begin() + found.last + 1, 1);
    ranges.push_back(found);
  }
  std::ranges::sort(ranges, {}, &KeyframeRange::first);
  return ranges;
}

}  // namespace mq
