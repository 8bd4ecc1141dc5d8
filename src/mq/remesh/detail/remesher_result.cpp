// The surface made of what is kept and of the strips, and where its vertices and triangles come
// from.

#include "mq/remesh/detail/remesher.h"

#include <algorithm>

#include "mq/mesh/components.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/unfold.h"
#include "mq/mesh/weld.h"
#include "mq/remesh/detail/clip_crossings.h"
#include "mq/remesh/detail/measure.h"
#include "mq/remesh/detail/retriangulate.h"

namespace mq {
namespace {

constexpr double least_area_of_squares = 1e-9;  // of a part's sides, below which it has no area

/// Takes out pieces that are edge to edge with nothing else and enclose no area, such as two
/// opposite triangles: nothing can be integrated over them.
void drop_parts_without_area(Seam& seam) {
  Mesh mesh;
  mesh.positions = seam.positions;
  mesh.triangles = seam.triangles;
  const Surface surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  const std::vector<int> part = triangle_components(surface);
  std::vector<double> area(part.size(), 0), squares(part.size(), 0);
  for (std::size_t t = 0; t < part.size(); ++t) {
    area[part[t]] += triangle_area(mesh, int(t));
    for (int k = 0; k < 3; ++k)
      squares[part[t]] +=
          (mesh.position(int(t), (k + 1) % 3) - mesh.position(int(t), k)).squaredNorm();
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < part.size(); ++t)
    if (area[part[t]] > least_area_of_squares * squares[part[t]]) {
      seam.triangles[kept] = seam.triangles[t];
      seam.from[kept++] = seam.from[t];
    }
  seam.triangles.resize(kept);
  seam.from.resize(kept);
}

}  // namespace

/// Where the vertices of the pair, now at these positions, lie on their surfaces.
std::vector<VertexOrigin> Remesher::find_origins(const std::vector<Vector3>& positions) const {
  std::vector<VertexOrigin> origins(positions.size());
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int v = pair_.mesh.triangles[t][k], source = pair_.source_triangle[t];
      VertexOrigin& origin = origins[v];
      if (origin.triangle >= 0) continue;
      const Mesh& mesh = pair_.of_target[v] ? target_.mesh : template_.mesh;
      origin = {{source, Vector3::Zero()}, pair_.of_target[v]};
      const auto& corners = mesh.triangles[source];
      const auto at = std::ranges::find(corners, pair_.source_vertex[v]);
      if (at != corners.end())
        origin.barycentric[at - corners.begin()] = 1;
      else
        origin.barycentric = closest_point(mesh, source, positions[v]).barycentric;
    }
  for (const char of_target : {0, 1}) {
    std::vector<int> moved;
    std::vector<Vector3> points;
    for (std::size_t v = 0; v < positions.size(); ++v)
      if (pair_.of_target[v] == of_target && positions[v] != pair_.mesh.positions[v]) {
        moved.push_back(int(v));
        points.push_back(positions[v]);
      }
    if (moved.empty()) continue;
    const auto places = (of_target ? target_finder_ : template_finder_)(points);
    for (std::size_t i = 0; i < moved.size(); ++i) origins[moved[i]] = {places[i], of_target};
  }
  return origins;
}

void Remesher::put(const Seam& seam) {
  std::vector<int> place(seam.positions.size(), -1);
  const std::vector<VertexOrigin> origins = find_origins(seam.positions);
  for (const Triangle& t : seam.triangles)
    for (const int v : t) place[v] = 0;
  // Vertices of the template first, each surface in its order.
  for (const char of_target : {0, 1})
    for (std::size_t v = 0; v < place.size(); ++v) {
      if (place[v] < 0 || pair_.of_target[v] != of_target) continue;
      place[v] = result_.mesh.vertex_count();
      const int source = pair_.source_vertex[v];
      result_.mesh.positions.push_back(seam.positions[v]);
      result_.origins.push_back(origins[v]);
      result_.template_vertices.push_back(of_target || seam.free[v] ? -1 : source);
      result_.target_vertices.push_back(of_target ? source : -1);
    }
  for (std::size_t i = 0; i < seam.triangles.size(); ++i) {
    const auto& [a, b, c] = seam.triangles[i];
    result_.mesh.triangles.push_back({place[a], place[b], place[c]});
    const int t = seam.from[i];
    const bool whole = t >= 0 && pair_.whole[t];
    const bool of_target = t >= 0 && pair_.triangle_of_target(t);
    result_.template_triangles.push_back(whole && !of_target ? pair_.source_triangle[t] : -1);
    result_.target_triangles.push_back(whole && of_target ? pair_.source_triangle[t] : -1);
  }
}

/// From vertices of the target that the template shows to where it shows them.
std::vector<Vector3> Remesher::offsets() const {
  std::vector<Vector3> offsets(pair_.mesh.positions.size(), Vector3::Zero());
  for (std::size_t v = 0; v < offsets.size(); ++v) {
    const int source = pair_.source_vertex[v];
    if (!pair_.of_target[v] || source < 0) continue;
    const int first = template_.mesh.vertex_count();
    const ClosestPoint& place = on_template_[source];
    if (scores_[first + source] > 1) continue;
    Vector3 there = Vector3::Zero(), normal = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      const int w = template_.mesh.triangles[place.triangle][k];
      there += place.barycentric[k] * template_.mesh.positions[w];
      normal += place.barycentric[k] * pair_.normals[w];
    }
    if (normal.dot(pair_.normals[v]) > 0.5) offsets[v] = there - pair_.mesh.positions[v];
  }
  return offsets;
}

/// Triangles that are not as they were in the pair, and cross others.
std::int64_t Remesher::count_crossings(const Seam& seam) const {
  std::vector<Triangle> changed, others;
  for (std::size_t i = 0; i < seam.triangles.size(); ++i) {
    const Triangle& t = seam.triangles[i];
    const bool moved =
        std::ranges::any_of(t, [&](int v) { return seam.positions[v] != pair_.mesh.positions[v]; });
    (seam.from[i] < 0 || moved ? changed : others).push_back(t);
  }
  return std::ranges::count(crossed(seam.positions, changed, others), char(1));
}

/// Vertices of the template stay, as what is kept does bit for bit.
void Remesher::unfold_added() {
  std::vector<char> fixed;
  for (const int v : result_.template_vertices) fixed.push_back(v >= 0);
  result_.mesh.positions = unfolded(result_.mesh, fixed);
}

void Remesher::finish(Cut& cut, const Progress& progress) {
  Stopwatch watch;
  const Retriangulation retriangulated = retriangulate(pair_, cut.kept, distorted_, options_.rest);
  std::vector<Triangle> triangles;
  std::vector<int> from;
  const auto take = [&](bool retriangulation, auto&& wanted) {
    for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
      if (cut.kept[t] && (retriangulated.triangles[t] != 0) == retriangulation && wanted(t)) {
        triangles.push_back(pair_.mesh.triangles[t]);
        from.push_back(retriangulation ? -1 : t);
      }
  };
  take(false, [&](int t) { return pair_.whole[t] && !pair_.triangle_of_target(t); });
  take(false, [&](int t) { return !pair_.whole[t] && !pair_.triangle_of_target(t); });
  take(false, [&](int t) { return pair_.triangle_of_target(t); });
  take(true, [](int) { return true; });
  triangles.insert(triangles.end(), cut.strips.begin(), cut.strips.end());
  from.resize(triangles.size(), -1);
  Seam seam{std::move(triangles), std::move(from), pair_.mesh.positions, offsets(),
            retriangulated.vertices};
  Seam better = seam;
  improve_seam(pair_, target_.mesh, target_finder_, better);
  if (count_crossings(better) <= count_crossings(seam)) seam = std::move(better);
  drop_parts_without_area(seam);
  put(seam);
  unfold_added();
  note("stitch", watch);
  progress.at(0.5);
  Stopwatch measuring;
  measure(result_, template_, target_, on_target_, on_template_);
  note("measure", measuring);
  progress.at(1);
}

}  // namespace mq
