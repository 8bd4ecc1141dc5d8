/// Triangles in `space_order` of their centres. Vertices are numbered as triangles first use them.

#include "mq/trace/trace_mesh.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/space_order.h"

namespace mq {
namespace {

/// Codes of walks need this many bits (see walk.h).
constexpr int most_triangles = 1 << 26;

}  // namespace

void TraceMesh::order_triangles(const Surface& surface) {
  source_triangles_ = triangle_space_order(surface.mesh);
  trace_triangles_.resize(source_triangles_.size());
  parallel_for(std::ssize(source_triangles_),
               [&](std::int64_t i) { trace_triangles_[source_triangles_[i]] = int(i); });
}

void TraceMesh::order_vertices(const Surface& surface) {
  const Mesh& mesh = surface.mesh;
  std::vector<int> number(mesh.positions.size(), -1);
  corners_.resize(mesh.triangles.size());
  for (int t = 0; t < triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      int& v = number[mesh.triangles[source_triangles_[t]][k]];
      if (v < 0) {
        v = int(source_vertices_.size());
        source_vertices_.push_back(mesh.triangles[source_triangles_[t]][k]);
      }
      corners_[t][k] = v;
    }
  for (int v = 0; v < int(number.size()); ++v)
    if (number[v] < 0) source_vertices_.push_back(v);
}

void TraceMesh::link(const Surface& surface) {
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  shapes_.resize(shapes.size());
  across_.resize(shapes.size());
  parallel_for(triangle_count(), [&](std::int64_t t) {
    const int source = source_triangles_[t];
    shapes_[t] = shapes[source];
    for (int k = 0; k < 3; ++k) {
      const HalfEdge twin = surface.twins[3 * source + (k + 1) % 3];
      const bool ends = twin < 0 || shapes[source].empty() || shapes[twin / 3].empty();
      across_[t][k] = ends ? -1 : 4 * trace_triangles_[twin / 3] + (twin % 3 + 2) % 3;
    }
  });
}

TraceMesh::TraceMesh(const Surface& surface, const Progress& progress) {
  require(surface.triangle_count() < most_triangles,
          fmt::format("the surface has {} triangles, and paths can be followed on {}: simplify it",
                      surface.triangle_count(), most_triangles));
  require(surface.triangle_count() > 0, "a surface without triangles has no paths");
  order_triangles(surface);
  progress.at(0.5);
  order_vertices(surface);
  link(surface);
  mean_edge_length_ = mq::mean_edge_length(surface);
  any_corner_.assign(source_vertices_.size(), -1);
  fan_begin_.assign(source_vertices_.size() + 1, 0);
  for (int t = 0; t < triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int v = corners_[t][k];
      if (any_corner_[v] < 0 || shapes_[any_corner_[v] / 3].empty()) any_corner_[v] = 3 * t + k;
      if (!shapes_[t].empty()) ++fan_begin_[v + 1];
    }
  for (int v = 0; v < vertex_count(); ++v) fan_begin_[v + 1] += fan_begin_[v];
  fans_.resize(fan_begin_.back());
  std::vector<int> next(fan_begin_.begin(), fan_begin_.end() - 1);
  for (int t = 0; t < triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      if (!shapes_[t].empty()) fans_[next[corners_[t][k]]++] = 3 * t + k;
  progress.at(1);
}

}  // namespace mq
