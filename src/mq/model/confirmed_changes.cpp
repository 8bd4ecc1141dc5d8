#include "mq/model/confirmed_changes.h"

#include <algorithm>
#include <array>

#include "mq/mesh/weld.h"

namespace mq {
namespace {

/// Seeds twice as many edges from each other are of one change.
constexpr int together_edges = 3;
/// Of a change's seeds, what is of one kind and fewer does not count.
constexpr double least_share = 0.1;

int corner_nearest_to(const ClosestPoint& place, const Surface& surface) {
  int corner = 0;
  place.barycentric.maxCoeff(&corner);
  return surface.mesh.triangles[place.triangle][corner];
}

void widen(const Surface& surface, int edges, SeedPlaces& places) {
  for (int ring = 0; ring < edges; ++ring) {
    const SeedPlaces before = places;
    for (const Triangle& t : surface.mesh.triangles) {
      const auto all = static_cast<unsigned char>(before[t[0]] | before[t[1]] | before[t[2]]);
      for (const int v : t) places[v] |= all;
    }
  }
}

}  // namespace

SeedPlaces places_of(const RemeshSeeds& seeds, const Surface& of_template, int edges) {
  SeedPlaces places;
  for (const char seed : seeds.of_template) places.push_back(seed ? seed_of_template : 0);
  for (std::size_t v = 0; v < seeds.of_target.size(); ++v)
    if (seeds.of_target[v])
      places[corner_nearest_to(seeds.on_template[v], of_template)] |= seed_of_target;
  widen(of_template, edges, places);
  return places;
}

std::vector<char> over_holes(const Surface& of_template, const Surface& frame,
                             const ClosestPointFinder& on_frame) {
  std::vector<char> over(of_template.mesh.positions.size(), 0);
  if (frame.boundary_edges == 0) return over;
  std::vector<char> border(frame.mesh.positions.size(), 0);
  for (HalfEdge h = 0; h < std::ssize(frame.twins); ++h)
    if (frame.twins[h] < 0)
      for (const int k : {h % 3, (h + 1) % 3}) border[frame.mesh.triangles[h / 3][k]] = 1;
  const std::vector<ClosestPoint> places = on_frame(of_template.mesh.positions);
  for (std::size_t v = 0; v < over.size(); ++v) {
    over[v] = 1;
    for (int k = 0; k < 3; ++k)
      if (places[v].barycentric[k] > 1e-6 && !border[frame.mesh.triangles[places[v].triangle][k]])
        over[v] = 0;
  }
  return over;
}

PassingPlaces passing_places(const RemeshSeeds& now, const Surface& of_template,
                             const std::vector<char>& over_hole,
                             const std::vector<SeedPlaces>& places) {
  const SeedPlaces seeds = places_of(now, of_template, 0);
  SeedPlaces wide = seeds;
  widen(of_template, together_edges, wide);
  DisjointSets changes(seeds.size());
  for (const Triangle& t : of_template.mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (wide[t[k]] && wide[t[(k + 1) % 3]]) changes.join(t[k], t[(k + 1) % 3]);
  // Of each kind, and of those that all frames after have.
  std::vector<std::array<int, 2>> all(seeds.size()), confirmed(seeds.size());
  const auto count = [&](int v, int kind) {
    const auto bit = static_cast<unsigned char>(kind == 0 ? seed_of_template : seed_of_target);
    const int change = changes.root(v);
    ++all[change][kind];
    confirmed[change][kind] += (kind == 0 && !over_hole[v]) || std::ranges::all_of(
        places, [&](const SeedPlaces& there) { return (there[v] & bit) != 0; });
  };
  for (std::size_t v = 0; v < now.of_template.size(); ++v)
    if (now.of_template[v]) count(int(v), 0);
  for (std::size_t v = 0; v < now.of_target.size(); ++v)
    if (now.of_target[v]) count(corner_nearest_to(now.on_template[v], of_template), 1);
  const auto passes = [&](int v) {
    const auto& [of_template_all, of_target_all] = all[changes.root(v)];
    const int total = of_template_all + of_target_all;
    bool is_passing = total == 0;
    for (int kind = 0; kind < 2; ++kind) {
      const int seeds_of_kind = all[changes.root(v)][kind];
      is_passing |= seeds_of_kind > least_share * total &&
                2 * confirmed[changes.root(v)][kind] < seeds_of_kind;
    }
    return is_passing && !places.empty();
  };
  PassingPlaces passing;
  for (std::size_t v = 0; v < now.of_template.size(); ++v) {
    passing.of_template.push_back(passes(int(v)));
    passing.pulled.push_back(passing.of_template.back() && wide[v]);
    if (now.of_template[v]) ++(passing.of_template[v] ? passing.seeds : passing.asked);
  }
  for (std::size_t v = 0; v < now.of_target.size(); ++v) {
    passing.of_target.push_back(passes(corner_nearest_to(now.on_template[v], of_template)));
    if (now.of_target[v]) ++(passing.of_target[v] ? passing.seeds : passing.asked);
  }
  return passing;
}

}  // namespace mq
