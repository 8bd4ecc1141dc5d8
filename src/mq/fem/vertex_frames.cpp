/// One walk around each vertex adds up the angles of its corners. The rotation along edge ij turns
/// the direction j → i, seen at j, into the one that goes on beyond i: that of i → j, plus π.

#include "mq/fem/vertex_frames.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {

namespace {

double corner_angle(const FlatTriangle& shape, int k) {
  return std::atan2(0.5, shape.half_cotangent(k));
}

void require_shapes(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  require(int(shapes.size()) == surface.triangle_count(),
          fmt::format("{} shapes were given for {} triangles", shapes.size(),
                      surface.triangle_count()));
}

/// Walks around vertices.
class Fans {
 public:
  Fans(const Surface& surface, const std::vector<FlatTriangle>& shapes)
      : surface_(surface),
        shapes_(shapes),
        visited_(shapes.size() * 3, 0),
        total_(surface.mesh.vertex_count(), 0.0),
        closed_(surface.mesh.vertex_count(), 0) {}

  VertexFrames frames() {
    const std::size_t half_edges = visited_.size();
    VertexFrames f{std::vector<double>(half_edges, 0.0), std::vector<double>(half_edges, 0.0),
                   std::vector<double>(half_edges, 0.0)};
    for (HalfEdge h = 0; h < HalfEdge(half_edges); ++h)
      if (!visited_[h] && !shapes_[h / 3].empty()) walk(first_of_fan(h), f);
    parallel_for(HalfEdge(half_edges), [&](std::int64_t h) { scale(HalfEdge(h), f); });
    parallel_for(HalfEdge(half_edges), [&](std::int64_t h) { turn_into_triangle(HalfEdge(h), f); });
    return f;
  }

 private:
  int source(HalfEdge h) const { return surface_.mesh.triangles[h / 3][h % 3]; }

  HalfEdge twin(HalfEdge h) const {
    const HalfEdge t = surface_.twins[h];
    return t >= 0 && !shapes_[t / 3].empty() ? t : -1;
  }

  /// Clockwise until the boundary, or once around.
  HalfEdge first_of_fan(HalfEdge start) const {
    HalfEdge h = start;
    while (twin(h) >= 0) {
      h = next(twin(h));
      if (h == start) break;
    }
    return h;
  }

  /// Counter-clockwise from the fan's first half-edge, adding up angles.
  void walk(HalfEdge first, VertexFrames& f) {
    const int vertex = source(first);
    double& angle = total_[vertex];
    HalfEdge h = first;
    while (true) {
      visited_[h] = 1;
      f.at_source[h] = angle;
      if (twin(h) >= 0) f.at_target[twin(h)] = angle;
      angle += corner_angle(shapes_[h / 3], h % 3);
      const HalfEdge across = twin(previous(h));
      if (across < 0) {
        f.at_target[previous(h)] = angle;
        return;
      }
      h = across;
      if (h == first) break;
    }
    closed_[vertex] = 1;
  }

  double stretch(int vertex) const {
    return closed_[vertex] ? 2 * std::numbers::pi / total_[vertex] : 1.0;
  }

  /// Around inner vertices angles are made to sum to 2π.
  void scale(HalfEdge h, VertexFrames& f) const {
    if (shapes_[h / 3].empty()) return;
    f.at_source[h] *= stretch(source(h));
    f.at_target[h] *= stretch(source(next(h)));
  }

  void turn_into_triangle(HalfEdge h, VertexFrames& f) const {
    const FlatTriangle& shape = shapes_[h / 3];
    if (shape.empty()) return;
    const Vector2 edge = shape.edge(h % 3);
    const double half = corner_angle(shape, h % 3) / 2;
    f.into_triangle[h] =
        std::atan2(edge.y(), edge.x()) + half - f.at_source[h] - half * stretch(source(h));
  }

  const Surface& surface_;
  const std::vector<FlatTriangle>& shapes_;
  std::vector<char> visited_;
  std::vector<double> total_;
  std::vector<char> closed_;
};

/// Adds w·|z_i − r·z_j|², r the rotation by `angle`.
void add_coupling(Entries& entries, int i, int j, double w, double angle) {
  const double c = w * std::cos(angle), s = w * std::sin(angle);
  for (int k = 0; k < 2; ++k) {
    entries.emplace_back(2 * i + k, 2 * i + k, w);
    entries.emplace_back(2 * j + k, 2 * j + k, w);
    entries.emplace_back(2 * i + k, 2 * j + k, -c);
    entries.emplace_back(2 * j + k, 2 * i + k, -c);
  }
  entries.emplace_back(2 * i, 2 * j + 1, s);
  entries.emplace_back(2 * j + 1, 2 * i, s);
  entries.emplace_back(2 * i + 1, 2 * j, -s);
  entries.emplace_back(2 * j, 2 * i + 1, -s);
}

}  // namespace

double VertexFrames::along(HalfEdge h) const {
  return at_source[h] - at_target[h] - std::numbers::pi;
}

VertexFrames vertex_frames(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  require_shapes(surface, shapes);
  return Fans(surface, shapes).frames();
}

SparseMatrix connection_laplacian(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  const VertexFrames frames = vertex_frames(surface, shapes);
  Entries entries;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && !shapes[t].empty(); ++k) {
      const Triangle& v = surface.mesh.triangles[t];
      add_coupling(entries, v[k], v[(k + 1) % 3], shapes[t].half_cotangent((k + 2) % 3),
                   frames.along(3 * t + k));
    }
  const int size = 2 * surface.mesh.vertex_count();
  return sparse_matrix(size, size, entries);
}

SparseMatrix vertex_prolongation(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                 const VertexFrames& frames) {
  require_shapes(surface, shapes);
  Entries entries;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && !shapes[t].empty(); ++k) {
      const int v = surface.mesh.triangles[t][k];
      const double angle = frames.into_triangle[3 * t + k];
      const double c = std::cos(angle) / 3, s = std::sin(angle) / 3;
      entries.insert(entries.end(), {{2 * t, 2 * v, c},
                                     {2 * t, 2 * v + 1, -s},
                                     {2 * t + 1, 2 * v, s},
                                     {2 * t + 1, 2 * v + 1, c}});
    }
  return sparse_matrix(2 * surface.triangle_count(), 2 * surface.mesh.vertex_count(), entries);
}

SparseMatrix circulation_along_edges(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                     const VertexFrames& frames, const Edges& edges) {
  require_shapes(surface, shapes);
  Entries entries;
  for (HalfEdge h = 0; h < HalfEdge(edges.from_half_edge.size()); ++h) {
    const int e = edges.from_half_edge[h];
    if (e < 0 || edges.sign[h] < 0) continue;
    const double half = 0.5 * shapes[h / 3].edge(h % 3).norm();
    const auto [i, j] = edges.vertices[e];
    const double out = frames.at_source[h], back = frames.at_target[h];
    entries.insert(entries.end(), {{e, 2 * i, half * std::cos(out)},
                                   {e, 2 * i + 1, half * std::sin(out)},
                                   {e, 2 * j, -half * std::cos(back)},
                                   {e, 2 * j + 1, -half * std::sin(back)}});
  }
  return sparse_matrix(edges.count(), 2 * surface.mesh.vertex_count(), entries);
}

}  // namespace mq
