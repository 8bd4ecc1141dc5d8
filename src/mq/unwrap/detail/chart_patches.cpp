// Dijkstra over triangles. A patch is a disc if its vertices − edges + triangles is 1, where
// vertices are counted as fans inside the patch, and if it is connected.

#include "mq/unwrap/detail/chart_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include "mq/base/infinity.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

constexpr int rounds = 4;                          // of moving centres
constexpr int straightenings = 2, spreadings = 6;  // of borders
constexpr double bending = 8;  // what turning by a right angle adds to a distance, in distances

/// Triangles and the ways between them.
class Dual {
 public:
  explicit Dual(const Surface& surface)
      : surface_(surface),
        normals_(triangle_normals(surface.mesh)),
        areas_(triangle_areas(surface.mesh)) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      centers_.push_back((surface.mesh.position(t, 0) + surface.mesh.position(t, 1) +
                          surface.mesh.position(t, 2)) /
                         3);
  }

  const std::vector<double>& areas() const { return areas_; }
  const Vector3& center(int t) const { return centers_[t]; }

  /// Per triangle that `inside` allows the nearest site's index, -1 elsewhere; distances on
  /// request.
  template <class Inside>
  std::vector<int> nearest(const std::vector<int>& sites, const Inside& inside,
                           std::vector<double>* distances = nullptr) const {
    using Entry = std::tuple<double, int, int>;  // distance, triangle, site
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    std::vector<int> found(centers_.size(), -1);
    std::vector<double> best(centers_.size(), infinity);
    for (std::size_t i = 0; i < sites.size(); ++i)
      queue.emplace(best[sites[i]] = 0, sites[i], int(i));
    while (!queue.empty()) {
      const auto [distance, t, site] = queue.top();
      queue.pop();
      if (found[t] >= 0) continue;
      found[t] = site;
      for (int k = 0; k < 3; ++k) {
        const HalfEdge twin = surface_.twins[3 * t + k];
        if (twin < 0 || found[twin / 3] >= 0 || !inside(t, twin / 3)) continue;
        const double through = distance + length(t, twin / 3);
        if (through >= best[twin / 3]) continue;
        best[twin / 3] = through;
        queue.emplace(through, twin / 3, site);
      }
    }
    if (distances) *distances = std::move(best);
    return found;
  }

  /// How much two neighbours have to do with each other, from 1 in a plane to 0.
  double conductance(int a, int b) const { return 1 / (1 + bending * turn(a, b)); }

 private:
  double turn(int a, int b) const { return std::max(0.0, 1 - normals_[a].dot(normals_[b])); }

  double length(int a, int b) const {
    return (centers_[a] - centers_[b]).norm() * (1 + bending * turn(a, b));
  }

  const Surface& surface_;
  std::vector<Vector3> centers_, normals_;
  std::vector<double> areas_;
};

bool in_charts(const Mesh& mesh, int t) {
  const auto [a, b, c] = mesh.triangles[t];
  return a != b && b != c && c != a;
}

std::vector<std::vector<int>> members_of(const std::vector<int>& patch, int count) {
  std::vector<std::vector<int>> members(count);
  for (int t = 0; t < int(patch.size()); ++t)
    if (patch[t] >= 0) members[patch[t]].push_back(t);
  return members;
}

/// Euler characteristic of each patch as a surface of its own; 1 for discs.
std::vector<int> euler_characteristics(const Surface& surface, const std::vector<int>& patch,
                                       int count) {
  const auto joined = [&](HalfEdge h) {
    return surface.twins[h] >= 0 && patch[surface.twins[h] / 3] == patch[h / 3];
  };
  std::vector<int> euler(count);
  DisjointSets corners(surface.twins.size());
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
    if (patch[h / 3] < 0) continue;
    if (h % 3 == 0) ++euler[patch[h / 3]];
    if (!joined(h) || h > surface.twins[h]) --euler[patch[h / 3]];
    if (joined(h)) corners.join(h, next(surface.twins[h]));
  }
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (patch[h / 3] >= 0 && corners.root(h) == h) ++euler[patch[h / 3]];
  return euler;
}

/// Gives the half around one of two triangles far apart the number `fresh`; where none are apart,
/// as those without area, the second half of them all. Neither half is empty.
void halve(const Dual& dual, std::vector<int>& patch, const std::vector<int>& members, int fresh) {
  const auto inside = [&](int a, int b) { return patch[a] == patch[b]; };
  const auto farthest = [&](int from) {
    std::vector<double> distances;
    dual.nearest({from}, inside, &distances);
    return *std::ranges::max_element(members, {}, [&](int t) { return distances[t]; });
  };
  const int a = farthest(members.front()), b = farthest(a), old = patch[a];
  const std::vector<int> half = dual.nearest({a, b}, inside);
  std::size_t given = 0;
  for (const int t : members)
    if (half[t] == 1) patch[t] = fresh, ++given;
  if (given > 0 && given < members.size()) return;
  for (std::size_t i = 0; i < members.size(); ++i)
    patch[members[i]] = 2 * i < members.size() ? old : fresh;
}

/// Straightens borders as if they were under tension (Merriman, Bence, Osher, Diffusion generated
/// motion by mean curvature, 1992): labels spread a little way, then the strongest takes the
/// triangle. Sharp bends let little through, so borders that lie along them stay.
void straighten(const Surface& surface, const Dual& dual, std::vector<int>& label) {
  using Weights = std::vector<std::pair<int, double>>;
  const auto add = [](Weights& to, int key, double weight) {
    for (auto& [k, w] : to)
      if (k == key) {
        w += weight;
        return;
      }
    to.emplace_back(key, weight);
  };
  for (int round = 0; round < straightenings; ++round) {
    std::vector<Weights> now(label.size()), then(label.size());
    for (std::size_t t = 0; t < label.size(); ++t)
      if (label[t] >= 0) now[t] = {{label[t], 1.0}};
    for (int step = 0; step < spreadings; ++step) {
      for (int t = 0; t < int(label.size()); ++t) {
        then[t].clear();
        double total = 0;
        std::array<double, 3> weights{};
        for (int k = 0; k < 3; ++k)
          if (const HalfEdge twin = surface.twins[3 * t + k]; twin >= 0)
            total += weights[k] = dual.conductance(t, twin / 3);
        if (total > 0)
          for (int k = 0; k < 3; ++k)
            if (weights[k] > 0)
              for (const auto& [key, weight] : now[surface.twins[3 * t + k] / 3])
                add(then[t], key, 0.5 * weight * weights[k] / total);
        for (const auto& [key, weight] : now[t]) add(then[t], key, (total > 0 ? 0.5 : 1) * weight);
      }
      now.swap(then);
    }
    for (std::size_t t = 0; t < label.size(); ++t) {
      double best = 0;
      for (const auto& [key, weight] : now[t])
        if (weight > best * (1 + 1e-9) || (weight > best * (1 - 1e-9) && key < label[t]))
          best = weight, label[t] = key;
    }
  }
}

/// Connected pieces of patches: per triangle the lowest triangle of its piece.
std::vector<int> pieces_of(const Surface& surface, const std::vector<int>& patch) {
  DisjointSets pieces(patch.size());
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (surface.twins[h] >= 0 && patch[h / 3] == patch[surface.twins[h] / 3])
      pieces.join(h / 3, surface.twins[h] / 3);
  std::vector<int> piece(patch.size());
  for (int t = 0; t < int(patch.size()); ++t) piece[t] = pieces.root(t);
  return piece;
}

/// All but the largest piece of each patch go to the neighbour with which they share most edges;
/// pieces without a neighbour become patches of their own.
void join_pieces(const Surface& surface, std::vector<int>& patch, int& count) {
  for (int round = 0; round < 8; ++round) {
    const std::vector<int> piece = pieces_of(surface, patch);
    std::vector<int> size(patch.size()), largest(count, -1);
    for (int t = 0; t < int(patch.size()); ++t) ++size[piece[t]];
    for (int t = 0; t < int(patch.size()); ++t) {
      if (patch[t] < 0) continue;
      int& best = largest[patch[t]];
      if (best < 0 || size[piece[t]] > size[best]) best = piece[t];
    }
    std::vector<std::vector<int>> stray(patch.size());
    bool any = false;
    for (int t = 0; t < int(patch.size()); ++t)
      if (patch[t] >= 0 && piece[t] != largest[patch[t]]) stray[piece[t]].push_back(t), any = true;
    if (!any) return;
    for (const std::vector<int>& triangles : stray) {
      std::vector<int> neighbours;
      for (const int t : triangles)
        for (int k = 0; k < 3; ++k)
          if (const HalfEdge twin = surface.twins[3 * t + k];
              twin >= 0 && patch[twin / 3] >= 0 && patch[twin / 3] != patch[t])
            neighbours.push_back(patch[twin / 3]);
      if (triangles.empty()) continue;
      std::ranges::sort(neighbours);
      int best = -1, most = 0;
      for (std::size_t i = 0, j = 0; i < neighbours.size(); i = j) {
        while (j < neighbours.size() && neighbours[j] == neighbours[i]) ++j;
        if (int(j - i) > most) most = int(j - i), best = neighbours[i];
      }
      if (best < 0) best = count++;
      for (const int t : triangles) patch[t] = best;
    }
  }
  // What still is in pieces becomes patches of their own.
  const std::vector<int> piece = pieces_of(surface, patch);
  std::vector<int> fresh(patch.size(), -1);
  count = 0;
  for (int t = 0; t < int(patch.size()); ++t) {
    if (patch[t] < 0) continue;
    if (fresh[piece[t]] < 0) fresh[piece[t]] = count++;
    patch[t] = fresh[piece[t]];
  }
}

/// Gives a triangle that stands into another patch, with two sides and all around the corner
/// between them, to that patch: the border gets shorter, and discs stay discs.
void remove_teeth(const Surface& surface, std::vector<int>& patch) {
  const auto other = [&](HalfEdge h) {
    const HalfEdge twin = surface.twins[h];
    return twin < 0 ? -1 : patch[twin / 3];
  };
  for (int round = 0, changed = 1; changed > 0 && round < 20; ++round) {
    changed = 0;
    for (int t = 0; t < int(patch.size()); ++t)
      for (int k = 0; k < 3; ++k) {
        // The tip is where edge k begins and the edge before it ends.
        const HalfEdge out = 3 * t + k, in = previous(out), base = next(out);
        const int into = other(out);
        if (into < 0 || into == patch[t] || other(in) != into || other(base) != patch[t]) continue;
        HalfEdge h = surface.twins[in];  // begins at the tip too
        while (h >= 0 && h != out && patch[h / 3] == into) h = surface.twins[previous(h)];
        if (h != out) continue;
        patch[t] = into;
        ++changed;
      }
  }
}

void halve_until_discs(const Surface& surface, const Dual& dual, std::vector<int>& patch,
                       int& count, const Progress& progress) {
  for (;;) {
    progress.check();
    const std::vector<int> euler = euler_characteristics(surface, patch, count);
    const auto members = members_of(patch, count);
    const int before = count;
    for (int c = 0; c < before; ++c)
      if (euler[c] != 1 && members[c].size() > 1) halve(dual, patch, members[c], count++);
    if (count == before) return;
  }
}

/// Those of one label by falling size, labels in their order.
SurfacePatches numbered(std::vector<int> patch, int count, const std::vector<int>& labels) {
  std::vector<int> size(count), label(count, -1), order;
  for (std::size_t t = 0; t < patch.size(); ++t)
    if (patch[t] >= 0) {
      // A piece that was given away counts for the patch that took it.
      if (size[patch[t]]++ == 0) order.push_back(patch[t]);
    }
  std::vector<std::vector<int>> votes(count);
  for (std::size_t t = 0; t < patch.size(); ++t)
    if (patch[t] >= 0 && labels[t] >= 0) votes[patch[t]].push_back(labels[t]);
  for (const int p : order) {
    std::ranges::sort(votes[p]);
    for (std::size_t i = 0, j = 0, most = 0; i < votes[p].size(); i = j) {
      while (j < votes[p].size() && votes[p][j] == votes[p][i]) ++j;
      if (j - i > most) most = j - i, label[p] = votes[p][i];
    }
  }
  std::ranges::stable_sort(order, [&](int a, int b) {
    return label[a] != label[b] ? label[a] < label[b] : size[a] > size[b];
  });
  std::vector<int> fresh(count, -1);
  SurfacePatches patches;
  for (const int p : order) {
    fresh[p] = patches.count++;
    patches.sources.push_back(label[p]);
  }
  for (int& p : patch)
    if (p >= 0) p = fresh[p];
  patches.patch = std::move(patch);
  return patches;
}

/// Triangles evenly by area, in the order of the mesh, so many per component as its area asks for.
std::vector<int> first_sites(const Surface& surface, const Dual& dual, int count) {
  const std::vector<int> component =
      pieces_of(surface, std::vector<int>(surface.triangle_count(), 0));
  std::vector<double> areas(surface.triangle_count()), sums(surface.triangle_count());
  double area = 0;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    areas[component[t]] += dual.areas()[t];
    area += dual.areas()[t];
  }
  std::vector<int> taken(surface.triangle_count()), sites;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (!in_charts(surface.mesh, t)) continue;
    const int c = component[t];
    const double share = area > 0 ? std::max(1.0, std::round(count * areas[c] / area)) : 1;
    sums[c] += dual.areas()[t];
    // The first of a component always, then whenever its share of the area is passed.
    if (taken[c] == 0 || (taken[c] < share && sums[c] * share >= areas[c] * taken[c])) {
      ++taken[c];
      sites.push_back(t);
    }
  }
  return sites;
}

}  // namespace

SurfacePatches make_patches(const Surface& surface, int count, const Progress& progress) {
  const Dual dual(surface);
  std::vector<int> sites = first_sites(surface, dual, count);
  const auto everywhere = [](int, int) { return true; };
  std::vector<int> patch;
  for (int round = 0;; ++round) {
    progress.at(0.9 * round / rounds);
    patch = dual.nearest(sites, everywhere);
    if (round == rounds) break;
    const auto members = members_of(patch, int(sites.size()));
    for (std::size_t c = 0; c < sites.size(); ++c) {
      Vector3 middle = Vector3::Zero();
      double area = 0;
      for (const int t : members[c]) {
        middle += dual.areas()[t] * dual.center(t);
        area += dual.areas()[t];
      }
      if (!(area > 0)) continue;
      middle /= area;
      sites[c] = *std::ranges::min_element(
          members[c], {}, [&](int t) { return (dual.center(t) - middle).squaredNorm(); });
    }
  }
  return make_discs(surface, std::move(patch), progress);
}

SurfacePatches make_discs(const Surface& surface, std::vector<int> labels,
                          const Progress& progress) {
  const Dual dual(surface);
  int count = 0;
  std::vector<int> sites, found(labels.size(), -1);
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (labels[t] >= 0) {
      count = std::max(count, labels[t] + 1);
      sites.push_back(t);
    }
  const std::vector<int> nearest = dual.nearest(sites, [](int, int) { return true; });
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (in_charts(surface.mesh, t)) found[t] = nearest[t] < 0 ? count : labels[sites[nearest[t]]];
  ++count;
  straighten(surface, dual, found);
  join_pieces(surface, found, count);
  remove_teeth(surface, found);
  halve_until_discs(surface, dual, found, count, progress);
  return numbered(std::move(found), count, labels);
}

void halve_patch(const Surface& surface, SurfacePatches& patches, int patch) {
  const Dual dual(surface);
  const auto members = members_of(patches.patch, patches.count);
  halve(dual, patches.patch, members[patch], patches.count++);
}

}  // namespace mq
