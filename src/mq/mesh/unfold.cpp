#include "mq/mesh/unfold.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "mq/mesh/weld.h"

namespace mq {
namespace {

/// A fold that is not gone after so many sweeps takes its neighbours along, one ring more each
/// time.
constexpr int sweeps_per_ring = 16, most_rings = 4;
/// Of the way to the mean of the neighbours that a sweep goes: less stays nearer to what was there.
constexpr double step = 0.25;
/// Twice the area over the square of the longest edge, from which on a triangle has a normal to
/// speak of.
constexpr double least_height = 1e-9;

int start(const Surface& surface, HalfEdge h) { return surface.mesh.triangles[h / 3][h % 3]; }
int end(const Surface& surface, HalfEdge h) { return start(surface, next(h)); }

/// The unit normals, 0 where a triangle is next to a line.
std::vector<Vector3> sound_normals(const Surface& surface, std::span<const Vector3> p) {
  std::vector<Vector3> normals(surface.mesh.triangles.size());
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const auto& [a, b, c] = surface.mesh.triangles[t];
    const Vector3 u = p[b] - p[a], v = p[c] - p[a], area = u.cross(v);
    const double longest =
        std::max({u.squaredNorm(), v.squaredNorm(), (p[c] - p[b]).squaredNorm()});
    normals[t] = area.norm() > least_height * longest ? area.normalized() : Vector3::Zero();
  }
  return normals;
}

/// Of the triangles that are asked about, those that are folded over.
std::vector<int> folds(const Surface& surface, std::span<const char> asked,
                       std::span<const Vector3> positions) {
  const std::vector<Vector3> normals = sound_normals(surface, positions);
  std::vector<int> found;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (!asked[t]) continue;
    Vector3 around = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      if (const HalfEdge twin = surface.twins[3 * t + k]; twin >= 0) around += normals[twin / 3];
    if (normals[t].isZero(0) || normals[t].dot(around) < 0) found.push_back(t);
  }
  return found;
}

/// The vertices within so many edges of these triangles.
std::vector<char> vertices_near(const Surface& surface, std::span<const int> triangles, int edges) {
  std::vector<char> found(surface.mesh.positions.size(), 0);
  for (const int t : triangles)
    for (const int v : surface.mesh.triangles[t]) found[v] = 1;
  for (int e = 0; e < edges; ++e) {
    const std::vector<char> before = found;
    for (const Triangle& t : surface.mesh.triangles)
      if (before[t[0]] || before[t[1]] || before[t[2]])
        for (const int v : t) found[v] = 1;
  }
  return found;
}

/// One sweep: vertices that are wanted go towards the mean of their neighbours, at a boundary of
/// those along it.
void smooth(const Surface& surface, std::span<const char> wanted, std::span<const char> boundary,
            std::vector<Vector3>& positions) {
  std::vector<int> count(positions.size(), 0);
  std::vector<Vector3> sum(positions.size(), Vector3::Zero());
  const auto add = [&](int to, int from) {
    if (!wanted[to]) return;
    sum[to] += positions[from];
    ++count[to];
  };
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int from = start(surface, h), to = end(surface, h);
    const bool open = surface.twins[h] < 0;
    if (open || !boundary[from]) add(from, to);
    if (open) add(to, from);
  }
  for (std::size_t v = 0; v < positions.size(); ++v)
    if (count[v] > 0) positions[v] = (1 - step) * positions[v] + step / count[v] * sum[v];
}

/// Puts back all that moved and hangs together with one of these triangles.
void put_back(const Surface& surface, std::span<const int> triangles, std::span<const char> moved,
              std::vector<Vector3>& positions) {
  DisjointSets groups(positions.size());
  for (const Triangle& t : surface.mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (moved[t[k]] && moved[t[(k + 1) % 3]]) groups.join(t[k], t[(k + 1) % 3]);
  std::vector<char> failed(positions.size(), 0);
  for (const int t : triangles)
    for (const int v : surface.mesh.triangles[t])
      if (moved[v]) failed[groups.root(v)] = 1;
  for (std::size_t v = 0; v < positions.size(); ++v)
    if (moved[v] && failed[groups.root(int(v))]) positions[v] = surface.mesh.positions[v];
}

/// The surface around folds, so that work goes by their number and not by the surface's size.
struct CutOut {
  Surface surface;
  std::vector<int> vertices;    ///< per vertex that of the whole
  std::vector<char> inner;      ///< per vertex: all its triangles are here
  std::vector<char> triangles;  ///< per triangle: all those beside it are here
};
CutOut part_around(const Surface& whole, std::span<const int> folded) {
  const std::vector<char> inner = vertices_near(whole, folded, most_rings + 2),
                          all = vertices_near(whole, folded, most_rings + 3);
  const auto touches = [](const Triangle& t, const std::vector<char>& vertices) {
    return vertices[t[0]] || vertices[t[1]] || vertices[t[2]];
  };
  std::vector<int> place(inner.size(), -1);
  Mesh mesh;
  CutOut part;
  std::vector<int> from;
  for (const Triangle& t : whole.mesh.triangles) {
    if (!touches(t, all)) continue;
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      if (place[t[k]] < 0) {
        place[t[k]] = mesh.vertex_count();
        mesh.positions.push_back(whole.mesh.positions[t[k]]);
        from.push_back(t[k]);
      }
      corners[k] = place[t[k]];
    }
    mesh.triangles.push_back(corners);
    part.triangles.push_back(touches(t, inner));
  }
  part.surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  for (const int v : part.surface.source_from_vertex) {
    part.vertices.push_back(from[v]);
    part.inner.push_back(inner[from[v]]);
  }
  return part;
}

}  // namespace

std::vector<Vector3> unfolded(const Mesh& mesh, std::span<const char> fixed) {
  const Surface whole = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  const std::vector<char> every(mesh.triangles.size(), 1);
  std::vector<int> folded = folds(whole, every, whole.mesh.positions);
  if (folded.empty()) return mesh.positions;
  std::vector<char> copies(mesh.positions.size(), 0);
  for (const int v : whole.source_from_vertex) copies[v] = char(std::min(copies[v] + 1, 2));

  const CutOut part = part_around(whole, folded);
  const Surface& surface = part.surface;
  std::vector<Vector3> positions = surface.mesh.positions;
  const auto source = [&](std::size_t v) { return whole.source_from_vertex[part.vertices[v]]; };
  std::vector<char> loose(positions.size()), moved(positions.size(), 0),
      boundary(positions.size(), 0);
  for (std::size_t v = 0; v < loose.size(); ++v)
    loose[v] = part.inner[v] && copies[source(v)] == 1 && (fixed.empty() || !fixed[source(v)]);
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h)
    if (surface.twins[h] < 0) boundary[start(surface, h)] = boundary[end(surface, h)] = 1;
  folded = folds(surface, part.triangles, positions);
  for (int sweep = 0; sweep < sweeps_per_ring * (1 + most_rings) && !folded.empty(); ++sweep) {
    std::vector<char> wanted = vertices_near(surface, folded, sweep / sweeps_per_ring);
    for (std::size_t v = 0; v < wanted.size(); ++v) moved[v] |= wanted[v] &= loose[v];
    smooth(surface, wanted, boundary, positions);
    folded = folds(surface, part.triangles, positions);
  }
  put_back(surface, folded, moved, positions);
  std::vector<Vector3> result = mesh.positions;
  for (std::size_t v = 0; v < moved.size(); ++v)
    if (moved[v]) result[source(v)] = positions[v];
  return result;
}

}  // namespace mq
