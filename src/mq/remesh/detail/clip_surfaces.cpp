// Whole triangles are kept or removed, so nothing has to be intersected, and no slivers arise. A
// half-edge is a cut where its triangle is kept and the one across the edge is not.

#include "mq/remesh/detail/clip_surfaces.h"

#include <algorithm>
#include <map>

#include "mq/mesh/geometry.h"

namespace mq {
namespace {

bool repeats_vertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

int tail(const Mesh& mesh, HalfEdge h) { return mesh.triangles[h / 3][h % 3]; }

double squared_length(const Mesh& mesh, HalfEdge h) {
  return (mesh.positions[tail(mesh, h)] - mesh.positions[tail(mesh, next(h))]).squaredNorm();
}

/// The halves of a split half-edge, or the whole of another, among the new half-edges.
struct Heirs {
  HalfEdge first = -1, second = -1;
};

class Halving {
 public:
  Halving(SurfacePair& pair, std::span<const int> triangles)
      : pair_(pair), heirs_(pair.twins.size()), middles_(pair.twins.size(), -1) {
    for (const int t : triangles) halve(longest_half_edge(pair_.mesh, t));
  }

  void run() {
    Mesh& mesh = pair_.mesh;
    const std::vector<HalfEdge> old = pair_.twins;
    std::fill(pair_.twins.begin(), pair_.twins.end(), -1);
    const int count = mesh.triangle_count();
    for (int t = 0; t < count; ++t) divide(t);
    pair_.twins.resize(3 * mesh.triangles.size(), -1);
    for (const auto& [h, g] : inner_) pair_.twins[h] = g, pair_.twins[g] = h;
    for (std::size_t h = 0; h < old.size(); ++h) {
      if (old[h] < 0) continue;
      const Heirs mine = heirs_[h], across = heirs_[std::size_t(old[h])];
      pair_.twins[mine.first] = mine.second < 0 ? across.first : across.second;
      if (mine.second >= 0) pair_.twins[mine.second] = across.first;
    }
  }

 private:
  void halve(HalfEdge h) {
    if (middles_[h] >= 0) return;
    Mesh& mesh = pair_.mesh;
    const int a = tail(mesh, h), b = tail(mesh, next(h)), m = mesh.vertex_count();
    mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) / 2);
    const Vector3 sum = pair_.normals[a] + pair_.normals[b];
    pair_.normals.push_back(sum.norm() > 0 ? Vector3(sum.normalized()) : pair_.normals[a]);
    pair_.of_target.push_back(pair_.of_target[a]);
    pair_.source_vertex.push_back(-1);
    middles_[h] = m;
    if (pair_.twins[h] >= 0) middles_[std::size_t(pair_.twins[h])] = m;
  }

  int add(const Triangle& triangle, int t) {
    pair_.mesh.triangles.push_back(triangle);
    pair_.source_triangle.push_back(pair_.source_triangle[t]);
    pair_.whole.push_back(0);
    return pair_.mesh.triangle_count() - 1;
  }

  /// Cuts a triangle at its first marked edge, then the two parts at theirs.
  void divide(int t) {
    std::array<int, 3> middles, origins;
    for (int k = 0; k < 3; ++k) middles[k] = middles_[3 * t + k], origins[k] = 2 * (3 * t + k);
    part(t, middles, origins);
  }

  /// `origins`: per edge 2·(old half-edge), + 1 for its second half; made inside: −1 − 2·i of the
  /// i-th such edge, and one less for its other side.
  void part(int t, const std::array<int, 3>& middles, const std::array<int, 3>& origins) {
    int k = -1;
    double length = -1;
    for (int i = 0; i < 3; ++i)
      if (middles[i] >= 0 && squared_length(pair_.mesh, 3 * t + i) > length)
        k = i, length = squared_length(pair_.mesh, 3 * t + i);
    if (k < 0) {
      for (int i = 0; i < 3; ++i) inherit(3 * t + i, origins[i]);
      return;
    }
    Triangle& old = pair_.mesh.triangles[t];
    const int i = (k + 1) % 3, j = (k + 2) % 3, m = middles[k];
    const int a = old[k], b = old[i], c = old[j];
    old = {a, m, c};
    pair_.whole[t] = 0;
    const int other = add({m, b, c}, t);
    const int made = -1 - 2 * int(inner_.size());
    inner_.emplace_back(-1, -1);
    // Only edges that were there before are marked, so origins[k] is not one made inside.
    part(t, {-1, -1, middles[j]}, {origins[k], made, origins[j]});
    part(other, {-1, middles[i], -1}, {origins[k] + 1, origins[i], made - 1});
  }

  void inherit(HalfEdge h, int origin) {
    if (origin < 0) {
      auto& edge = inner_[std::size_t((-1 - origin) / 2)];
      (origin % 2 != 0 ? edge.first : edge.second) = h;
      return;
    }
    Heirs& heirs = heirs_[std::size_t(origin / 2)];
    (origin % 2 == 0 ? heirs.first : heirs.second) = h;
  }

  SurfacePair& pair_;
  std::vector<Heirs> heirs_;
  std::vector<int> middles_;
  std::vector<std::pair<HalfEdge, HalfEdge>> inner_;
};

bool is_cut(const SurfacePair& pair, const std::vector<char>& kept, HalfEdge h) {
  const HalfEdge twin = pair.twins[h];
  return kept[h / 3] && twin >= 0 && !kept[twin / 3];
}

/// Whether what is kept ends at the half-edge, cut or not.
bool is_end(const SurfacePair& pair, const std::vector<char>& kept, HalfEdge h) {
  const HalfEdge twin = pair.twins[h];
  return kept[h / 3] && (twin < 0 || !kept[twin / 3]);
}

/// The half-edge with which the border goes on after h, an end of what is kept.
HalfEdge after(const SurfacePair& pair, const std::vector<char>& kept, HalfEdge h) {
  HalfEdge g = next(h);
  while (!is_end(pair, kept, g)) g = next(pair.twins[g]);
  return g;
}

/// The kept triangles around the tail of h, an end of what is kept, as far as they hang together.
std::vector<int> fan(const SurfacePair& pair, const std::vector<char>& kept, HalfEdge h) {
  std::vector<int> triangles{h / 3};
  for (HalfEdge g = previous(h); !is_end(pair, kept, g); g = previous(pair.twins[g]))
    triangles.push_back(pair.twins[g] / 3);
  return triangles;
}

bool drop_ears(const SurfacePair& pair, std::vector<char>& kept) {
  bool changed = false;
  std::vector<int> asked;
  for (int t = 0; t < pair.mesh.triangle_count(); ++t)
    if (kept[t]) asked.push_back(t);
  while (!asked.empty()) {
    std::vector<int> again;
    for (const int t : asked) {
      if (!kept[t]) continue;
      int cuts = 0;
      for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) cuts += is_cut(pair, kept, h);
      if (cuts < 2) continue;
      kept[t] = 0;
      changed = true;
      for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h)
        if (pair.twins[h] >= 0) again.push_back(pair.twins[h] / 3);
    }
    asked = std::move(again);
  }
  return changed;
}

bool drop_small_fans(const SurfacePair& pair, std::vector<char>& kept) {
  std::vector<std::pair<int, HalfEdge>> ends;  // by the vertex where they begin
  for (HalfEdge h = 0; h < std::ssize(pair.twins); ++h)
    if (is_end(pair, kept, h) && !repeats_vertex(pair.mesh.triangles[h / 3]))
      ends.emplace_back(tail(pair.mesh, h), h);
  std::ranges::sort(ends);
  std::vector<int> dropped;
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t j = i;
    while (j < ends.size() && ends[j].first == ends[i].first) ++j;
    if (j - i > 1) {
      std::vector<std::vector<int>> fans;
      bool cut = false;
      for (std::size_t k = i; k < j; ++k) {
        fans.push_back(fan(pair, kept, ends[k].second));
        cut |= is_cut(pair, kept, ends[k].second);
      }
      const auto largest =
          std::ranges::max_element(fans, {}, [](const auto& f) { return f.size(); });
      for (auto f = fans.begin(); f != fans.end(); ++f)
        if (f != largest && cut) dropped.insert(dropped.end(), f->begin(), f->end());
    }
    i = j;
  }
  for (const int t : dropped) kept[t] = 0;
  return !dropped.empty();
}

void append(SurfacePair& pair, const Surface& surface, char of_target) {
  const int vertices = pair.mesh.vertex_count(), half_edges = 3 * pair.mesh.triangle_count();
  const Mesh& mesh = surface.mesh;
  pair.mesh.positions.insert(pair.mesh.positions.end(), mesh.positions.begin(),
                             mesh.positions.end());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    pair.mesh.triangles.push_back({a + vertices, b + vertices, c + vertices});
    pair.source_triangle.push_back(t);
    pair.whole.push_back(1);
  }
  for (const HalfEdge twin : surface.twins) pair.twins.push_back(twin < 0 ? -1 : twin + half_edges);
  const std::vector<Vector3> normals = vertex_normals(mesh);
  pair.normals.insert(pair.normals.end(), normals.begin(), normals.end());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    pair.of_target.push_back(of_target);
    pair.source_vertex.push_back(v);
  }
}

}  // namespace

HalfEdge longest_half_edge(const Mesh& mesh, int triangle) {
  HalfEdge best = 3 * triangle;
  for (HalfEdge h = best + 1; h < 3 * triangle + 3; ++h)
    if (squared_length(mesh, h) > squared_length(mesh, best)) best = h;
  return best;
}

double longest_edge(const Mesh& mesh, int triangle) {
  return std::sqrt(squared_length(mesh, longest_half_edge(mesh, triangle)));
}

SurfacePair join(const Surface& first, const Surface& second) {
  SurfacePair pair;
  append(pair, first, 0);
  append(pair, second, 1);
  return pair;
}

void halve_longest_edges(SurfacePair& pair, std::span<const int> triangles) {
  Halving(pair, triangles).run();
}

void clean_cut(const SurfacePair& pair, std::vector<char>& kept) {
  bool changed = true;
  while (changed) {
    changed = drop_ears(pair, kept);
    changed |= drop_small_fans(pair, kept);
  }
}

std::vector<CutCurve> cut_curves(const SurfacePair& pair, const std::vector<char>& kept) {
  std::vector<CutCurve> curves;
  std::vector<char> walked(pair.twins.size(), 0);
  const auto follow = [&](HalfEdge start, CutCurve::Kind kind) {
    CutCurve curve{{}, kind};
    HalfEdge h = start;
    for (; is_cut(pair, kept, h) && !walked[h]; h = after(pair, kept, h)) {
      walked[h] = 1;
      curve.vertices.push_back(tail(pair.mesh, h));
    }
    if (kind == CutCurve::Kind::open) curve.vertices.push_back(tail(pair.mesh, h));
    curves.push_back(std::move(curve));
  };
  // Open curves begin where a border that is no cut passes over into one.
  for (HalfEdge h = 0; h < std::ssize(pair.twins); ++h)
    if (is_end(pair, kept, h) && !is_cut(pair, kept, h) &&
        !repeats_vertex(pair.mesh.triangles[h / 3])) {
      const HalfEdge g = after(pair, kept, h);
      if (is_cut(pair, kept, g)) follow(g, CutCurve::Kind::open);
    }
  for (HalfEdge h = 0; h < std::ssize(pair.twins); ++h)
    if (is_cut(pair, kept, h) && !walked[h]) follow(h, CutCurve::Kind::closed);
  return curves;
}

}  // namespace mq
