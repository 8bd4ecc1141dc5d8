#include "mq/model/moved_vertices.h"

#include <algorithm>
#include <cmath>

#include "mq/io/normals.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"

namespace mq {

std::optional<double> BeforeAfter::change() const {
  if (before == 0) return std::nullopt;
  return after / before - 1;
}

ShapeChange shape_change(const Surface& surface, std::span<const Vector3> positions) {
  Mesh after = surface.mesh;
  after.positions.assign(positions.begin(), positions.end());
  double sum = 0, largest = 0;
  for (std::size_t v = 0; v < after.positions.size(); ++v) {
    const double moved = (after.positions[v] - surface.mesh.positions[v]).squaredNorm();
    sum += moved;
    largest = std::max(largest, moved);
  }
  ShapeChange change{.rms_moved = std::sqrt(sum / std::max(1.0, double(after.positions.size()))),
                     .largest_moved = std::sqrt(largest),
                     .area = {total_area(surface.mesh), total_area(after)},
                     .volume = {}};
  if (surface.boundary_edges == 0)
    change.volume = {enclosed_volume(surface.mesh), enclosed_volume(after)};
  return change;
}

bool move_vertices(std::span<const Vector3> positions, TexturedModel& model) {
  bool moved = false;
  Mesh& mesh = model.model.mesh;
  const std::vector<Vector3>& from = model.surface.mesh.positions;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const int source = model.surface.vertex_from_source[v];
    if (source < 0) continue;
    const auto here = std::size_t(source);
    if (positions[here] == from[here]) continue;
    moved = true;
    mesh.positions[v] += positions[here] - from[here];
  }
  return moved && leave_out_normals(model.model);
}

}  // namespace mq
