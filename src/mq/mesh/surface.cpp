// Vertices become classes (welding), classes become twins (edges), twins become fans (vertices of
// the result). Each step writes an array per vertex, half-edge or corner, so that it can run in
// parallel and the result does not depend on how; the defects are read off these arrays at the end.

#include "mq/mesh/surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/mesh/check.h"
#include "mq/mesh/norm.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

using Ids = std::vector<std::int64_t>;

constexpr int largest_edge_group = 16;  // half-edges at one edge that are told apart

// ---- Triangles ----

/// Whether three points are collinear to rounding: |a × b| <= 8ε |a||b| for the shortest edges.
bool collinear(const Vector3& p, const Vector3& q, const Vector3& r) {
  const std::array<Vector3, 3> edges{q - p, r - q, p - r};
  std::array<double, 3> lengths;
  for (int k = 0; k < 3; ++k) lengths[k] = safe_norm(edges[k]);
  const int longest = int(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  const int i = (longest + 1) % 3, j = (longest + 2) % 3;
  if (lengths[i] == 0 || lengths[j] == 0) return true;
  const Vector3 a = edges[i] / lengths[i], b = edges[j] / lengths[j];
  return a.cross(b).norm() <= 8 * std::numeric_limits<double>::epsilon();
}

/// Items in the order of their keys, 0 to keys - 1, equal keys in the order of the items.
/// Items with a negative key are left out.
struct Buckets {
  std::vector<std::int64_t> begin;
  std::vector<int> items;

  template <class Key>
  Buckets(int item_count, int keys, const Key& key) : begin(std::size_t(keys) + 1) {
    for (int i = 0; i < item_count; ++i)
      if (key(i) >= 0) ++begin[key(i) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    items.resize(begin.back());
    std::vector<std::int64_t> fill(begin.begin(), begin.end() - 1);
    for (int i = 0; i < item_count; ++i)
      if (key(i) >= 0) items[fill[key(i)]++] = i;
  }
  std::span<int> bucket(std::int64_t k) {
    return {items.data() + begin[k], std::size_t(begin[k + 1] - begin[k])};
  }
};

enum class EdgeState : char { plain, nonmanifold, touching, inconsistent };

/// The mesh on its way to a surface. Vertices are welded classes until `number_vertices`.
struct Builder {
  const Mesh& source;
  std::vector<int> welded;          // per source vertex the lowest of its class
  std::vector<Triangle> corners{};  // per triangle its classes
  std::vector<char> collapsed{};    // per triangle: two corners are of one class
  std::vector<char> duplicate{};    // per triangle: repeats an earlier one
  std::vector<char> two_sided{};    // per triangle: an earlier one flipped
  std::vector<HalfEdge> twins{};
  std::vector<EdgeState> states{};  // at the lowest half-edge of an edge
  std::vector<int> fans{};          // per half-edge the fan of the corner it leaves
  std::vector<int> fan_source{};    // per fan its lowest source vertex

  int half_edge_count() const { return 3 * source.triangle_count(); }
  int from(HalfEdge h) const { return corners[h / 3][h % 3]; }
  int to(HalfEdge h) const { return from(next(h)); }
  int apex(HalfEdge h) const { return from(previous(h)); }
  int source_vertex(HalfEdge h) const { return source.triangles[h / 3][h % 3]; }
  bool alone(HalfEdge h) const { return collapsed[h / 3] || duplicate[h / 3]; }

  const Vector3& position(int triangle, int corner) const {
    return source.positions[corners[triangle][corner]];
  }

  void find_triangles(Surface& surface);
  void find_repeated_triangles();
  void join_edges();
  void join_edge(std::span<HalfEdge> group);
  void join_unique(std::span<const HalfEdge> group, const auto& allowed);
  void find_fans();
  void number_vertices(Surface& surface);
};

/// Corners, and which triangles have no area.
void Builder::find_triangles(Surface& surface) {
  const int count = source.triangle_count();
  corners.resize(count);
  collapsed.assign(count, 0);
  duplicate.assign(count, 0);
  two_sided.assign(count, 0);
  surface.degenerate.assign(count, 0);
  parallel_for(count, [&](std::int64_t t) {
    Triangle& c = corners[t];
    for (int k = 0; k < 3; ++k) c[k] = welded[source.triangles[t][k]];
    collapsed[t] = c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
    surface.degenerate[t] =
        collapsed[t] || collinear(position(int(t), 0), position(int(t), 1), position(int(t), 2));
  });
  surface.area = parallel_sum(count, 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (int t = int(begin); t < int(end); ++t)
      if (!surface.degenerate[t]) {
        const Vector3 a = position(t, 1) - position(t, 0), b = position(t, 2) - position(t, 0);
        sum += 0.5 * safe_norm(a.cross(b));
      }
    return sum;
  });
}

void Builder::find_repeated_triangles() {
  const auto lowest = [&](int t) {
    return int(std::min_element(corners[t].begin(), corners[t].end()) - corners[t].begin());
  };
  Buckets buckets(int(corners.size()), source.vertex_count(),
                  [&](int t) { return collapsed[t] ? -1 : corners[t][lowest(t)]; });
  // (low, high) of the two other corners, 1 if they come in this order, the triangle
  using Key = std::array<int, 4>;
  parallel_blocks(source.vertex_count(), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Key> keys;
    for (std::int64_t v = begin; v < end; ++v) {
      keys.clear();
      for (const int t : buckets.bucket(v)) {
        const int k = lowest(t), b = corners[t][(k + 1) % 3], c = corners[t][(k + 2) % 3];
        keys.push_back({std::min(b, c), std::max(b, c), b < c, t});
      }
      std::sort(keys.begin(), keys.end());
      for (std::size_t i = 1; i < keys.size(); ++i) {
        const Key &a = keys[i - 1], &b = keys[i];
        if (a[0] != b[0] || a[1] != b[1]) continue;
        if (a[2] == b[2])
          duplicate[b[3]] = 1;
        else
          two_sided[b[3]] = 1;
      }
    }
  });
}

/// Joins the half-edges that are each other's only allowed partner.
void Builder::join_unique(std::span<const HalfEdge> group, const auto& allowed) {
  std::vector<HalfEdge> partners(group.size(), -1);
  for (std::size_t i = 0; i < group.size(); ++i) {
    int found = 0;
    for (std::size_t j = 0; j < group.size(); ++j) {
      const HalfEdge a = group[i], b = group[j];
      if (twins[a] >= 0 || twins[b] >= 0 || from(a) == from(b) || !allowed(a, b)) continue;
      partners[i] = b;
      ++found;
    }
    if (found != 1) partners[i] = -1;
  }
  for (std::size_t i = 0; i < group.size(); ++i)
    for (std::size_t j = 0; j < group.size(); ++j)
      if (partners[i] == group[j] && partners[j] == group[i]) twins[group[i]] = group[j];
}

/// Decides on all half-edges of one edge, in ascending order.
void Builder::join_edge(std::span<HalfEdge> group) {
  if (group.size() < 2) return;
  const HalfEdge a = group[0], b = group[1];
  if (group.size() == 2) {
    if (from(a) == from(b))
      states[a] = EdgeState::inconsistent;
    else
      twins[a] = b, twins[b] = a;
    return;
  }
  const auto source_edge = [&](HalfEdge h) {
    return std::minmax({source_vertex(h), source_vertex(next(h))});
  };
  std::vector<std::pair<int, int>> sources;
  for (const HalfEdge h : group) sources.push_back(source_edge(h));
  std::sort(sources.begin(), sources.end());
  states[a] = EdgeState::touching;
  for (std::size_t i = 2; i < sources.size(); ++i)
    if (sources[i] == sources[i - 2]) states[a] = EdgeState::nonmanifold;
  if (group.size() > largest_edge_group) return;
  join_unique(group, [&](HalfEdge x, HalfEdge y) { return source_edge(x) == source_edge(y); });
  join_unique(group, [&](HalfEdge x, HalfEdge y) { return apex(x) != apex(y); });
}

void Builder::join_edges() {
  twins.assign(half_edge_count(), -1);
  states.assign(half_edge_count(), EdgeState::plain);
  Buckets buckets(half_edge_count(), source.vertex_count(),
                  [&](HalfEdge h) { return alone(h) ? -1 : std::min(from(h), to(h)); });
  parallel_blocks(source.vertex_count(), 4096, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const std::span<HalfEdge> bucket = buckets.bucket(v);
      const auto high = [&](HalfEdge h) { return std::max(from(h), to(h)); };
      std::sort(bucket.begin(), bucket.end(), [&](HalfEdge a, HalfEdge b) {
        return high(a) != high(b) ? high(a) < high(b) : a < b;
      });
      for (std::size_t i = 0, j = 0; i < bucket.size(); i = j) {
        while (j < bucket.size() && high(bucket[j]) == high(bucket[i])) ++j;
        join_edge(bucket.subspan(i, j - i));
      }
    }
  });
}

/// Corners around a vertex that are connected through twins are one fan.
void Builder::find_fans() {
  fans.assign(half_edge_count(), -1);
  for (HalfEdge start = 0; start < half_edge_count(); ++start) {
    if (fans[start] >= 0 || collapsed[start / 3]) continue;
    const int fan = int(fan_source.size());
    fan_source.push_back(source_vertex(start));
    const auto visit = [&](HalfEdge h) {
      fans[h] = fan;
      fan_source[fan] = std::min(fan_source[fan], source_vertex(h));
    };
    HalfEdge h = start;
    do {  // clockwise
      visit(h);
      h = twins[h] < 0 ? -1 : next(twins[h]);
    } while (h >= 0 && h != start);
    if (h == start) continue;
    for (h = start; h >= 0; h = twins[previous(h)]) visit(h);  // the rest, counter-clockwise
  }
}

/// Fans become vertices in the order of their lowest source vertices: a mesh without defects keeps
/// its numbers. Corners of collapsed triangles take the first fan of their class, so that it shows.
void Builder::number_vertices(Surface& surface) {
  std::vector<int> source_fan(source.vertex_count(), -1), class_fan(source.vertex_count(), -1);
  const auto keep_first = [](int& first, int fan) { first = first < 0 ? fan : first; };
  for (HalfEdge h = 0; h < half_edge_count(); ++h)
    if (fans[h] >= 0) {
      keep_first(source_fan[source_vertex(h)], fans[h]);
      keep_first(class_fan[from(h)], fans[h]);
    }
  for (HalfEdge h = 0; h < half_edge_count(); ++h)
    if (fans[h] < 0) {
      if (class_fan[from(h)] < 0) {
        class_fan[from(h)] = int(fan_source.size());
        fan_source.push_back(source_vertex(h));
      }
      fans[h] = class_fan[from(h)];
      keep_first(source_fan[source_vertex(h)], fans[h]);
    }
  const Buckets order(int(fan_source.size()), source.vertex_count(),
                      [&](int fan) { return fan_source[fan]; });
  std::vector<int> vertex_of_fan(fan_source.size());
  for (const int fan : order.items) {
    vertex_of_fan[fan] = int(surface.source_from_vertex.size());
    surface.source_from_vertex.push_back(fan_source[fan]);
    surface.mesh.positions.push_back(source.positions[welded[fan_source[fan]]]);
  }
  for (HalfEdge h = 0; h < half_edge_count(); ++h)
    surface.mesh.triangles[h / 3][h % 3] = vertex_of_fan[fans[h]];
  surface.vertex_from_source.assign(source.vertex_count(), -1);
  for (int s = 0; s < source.vertex_count(); ++s)
    if (source_fan[s] >= 0) surface.vertex_from_source[s] = vertex_of_fan[source_fan[s]];
}

// ---- What is said of the result ----

void count_topology(const Builder& builder, Surface& surface) {
  DisjointSets components(surface.mesh.triangles.size());
  std::vector<char> used(surface.mesh.positions.size());
  int faces = 0, edges = 0;
  for (HalfEdge h = 0; h < builder.half_edge_count(); ++h) {
    if (builder.collapsed[h / 3]) continue;
    const HalfEdge twin = surface.twins[h];
    if (h % 3 == 0) ++faces;
    if (h > twin) ++edges;  // at a boundary twin is -1
    if (twin < 0)
      ++surface.boundary_edges;
    else
      components.join(h / 3, twin / 3);
    used[surface.mesh.triangles[h / 3][h % 3]] = 1;
  }
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (!builder.collapsed[t] && components.root(t) == t) ++surface.components;
  const int vertices = int(std::count(used.begin(), used.end(), 1));
  surface.euler_characteristic = vertices - edges + faces;
}

void list_vertices(const Builder& builder, const WeldOptions& weld, Surface& surface) {
  const int count = builder.source.vertex_count();
  std::vector<char> leads(count);
  for (const int s : surface.source_from_vertex) leads[s] = 1;
  std::vector<int> vertex(count, -1);  // of the first corner of a fan seen at a source vertex
  std::vector<char> split(count);
  for (HalfEdge h = 0; h < builder.half_edge_count(); ++h) {
    if (builder.alone(h)) continue;
    const int s = builder.source_vertex(h), v = surface.mesh.triangles[h / 3][h % 3];
    if (vertex[s] >= 0 && vertex[s] != v) split[s] = 1;
    vertex[s] = v;
  }
  Ids welded, unreferenced, nonmanifold;
  for (int s = 0; s < count; ++s) {
    if (surface.vertex_from_source[s] < 0)
      unreferenced.push_back(s);
    else if (!leads[s])
      welded.push_back(s);
    if (split[s]) nonmanifold.push_back(s);
  }
  using enum Defect::Severity;
  add_defect(
      surface.defects, "welded_vertices", note, "vertex", welded,
      weld.kind == WeldOptions::Kind::distance
          ? fmt::format("closer than {} to another vertex, joined with it", weld.distance)
          : fmt::format("at the same position as another vertex, joined with it (as exporters "
                        "split vertices at seams); {} none keeps them apart",
                        option_name("weld")));
  add_defect(surface.defects, "unreferenced_vertices", note, "vertex", unreferenced,
             "used by no triangle; they carry no signal");
  add_defect(surface.defects, "nonmanifold_vertices", warning, "vertex", nonmanifold,
             "several parts of the surface meet in these vertices alone, or at a cut edge: they "
             "are treated as one vertex per part",
             "joining parts of the surface alone: taken as one for each part");
}

void list_edges(const Builder& builder, Surface& surface) {
  Ids nonmanifold, touching, inconsistent;
  for (HalfEdge h = 0; h < builder.half_edge_count(); ++h) {
    switch (builder.states[h]) {
      case EdgeState::plain: break;
      case EdgeState::nonmanifold: nonmanifold.push_back(h); break;
      case EdgeState::touching: touching.push_back(h); break;
      case EdgeState::inconsistent: inconsistent.push_back(h); break;
    }
  }
  using enum Defect::Severity;
  add_defect(surface.defects, "nonmanifold_edges", warning, "edge", nonmanifold,
             "more than two triangles share these edges (each named by its lowest half-edge, "
             "3 * triangle + corner): where no pair stands out, the surface is cut there",
             "of more than two triangles: cut there where no pair stands out");
  add_defect(surface.defects, "touching_edges", warning, "edge", touching,
             "more than two triangles meet at these edges because vertices were joined: triangles "
             "that the file joins stay joined, the surface is cut between the others",
             "where more than two triangles touch: cut between those that the file parts");
  add_defect(surface.defects, "inconsistent_edges", warning, "edge", inconsistent,
             "the two triangles of these edges are oriented against each other: the surface is cut "
             "there; orient the faces alike to have it whole",
             "between triangles that face against each other: cut there");
}

void list_triangles(const Builder& builder, Surface& surface) {
  Ids degenerate, by_weld, duplicate, two_sided;
  const auto& p = builder.source.positions;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Triangle& s = builder.source.triangles[t];
    const bool had_area = surface.degenerate[t] && !collinear(p[s[0]], p[s[1]], p[s[2]]);
    if (had_area)
      by_weld.push_back(t);
    else if (surface.degenerate[t])
      degenerate.push_back(t);
    if (builder.duplicate[t]) duplicate.push_back(t);
    if (builder.two_sided[t]) two_sided.push_back(t);
  }
  using enum Defect::Severity;
  add_defect(surface.defects, "degenerate_triangles", warning, "triangle", degenerate,
             "triangles without area: no integral sees them", "without area: no integral sees them");
  add_defect(surface.defects, "triangles_collapsed_by_weld", warning, "triangle", by_weld,
             "triangles that lost their area when vertices were joined: weld with a smaller "
             "distance to keep them",
             "that lost their area when vertices were joined: no integral sees them");
  add_defect(surface.defects, "duplicate_triangles", warning, "triangle", duplicate,
             "triangles that repeat an earlier one: they stand alone, beside the surface",
             "that repeat an earlier one: they stand alone, beside the surface");
  add_defect(surface.defects, "two_sided_triangles", note, "triangle", two_sided,
             "triangles that are an earlier one flipped: front and back are separate layers");
}

}  // namespace

Surface make_surface(const Mesh& mesh, const WeldOptions& weld, const Progress& progress) {
  check_mesh(mesh);
  const std::vector<char> referenced = referenced_vertices(mesh);
  progress.at(0.1);
  Builder builder{.source = mesh, .welded = weld_vertices(mesh, referenced, weld)};
  progress.at(0.3);

  Surface surface;
  surface.mesh.triangles.resize(mesh.triangles.size());
  surface.mesh.uvs = mesh.uvs;
  surface.mesh.corner_uvs = mesh.corner_uvs;
  surface.mesh.textures = mesh.textures;
  builder.find_triangles(surface);
  builder.find_repeated_triangles();
  progress.at(0.5);
  builder.join_edges();
  progress.at(0.7);
  builder.find_fans();
  builder.number_vertices(surface);
  progress.at(0.9);

  surface.twins = std::move(builder.twins);
  count_topology(builder, surface);
  list_vertices(builder, weld, surface);
  list_edges(builder, surface);
  list_triangles(builder, surface);
  progress.at(1);
  return surface;
}

}  // namespace mq
