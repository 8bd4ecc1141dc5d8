#include "mq/model/model_shape.h"

#include <algorithm>
#include <cmath>

#include "mq/io/normals.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"

namespace mq {
namespace {

double total_area(const Mesh& mesh) {
  double sum = 0;
  for (const double area : triangle_areas(mesh)) sum += area;
  return sum;
}

}  // namespace

ShapeChange shape_change(const Surface& surface, std::span<const Vector3> positions) {
  const Mesh& before = surface.mesh;
  double sum = 0, largest = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const double moved = (positions[v] - before.positions[v]).squaredNorm();
    sum += moved;
    largest = std::max(largest, moved);
  }
  Mesh after = before;
  after.positions.assign(positions.begin(), positions.end());
  ShapeChange change;
  change.rms_moved = std::sqrt(sum / std::max(1.0, double(positions.size())));
  change.largest_moved = std::sqrt(largest);
  change.area = {total_area(before), total_area(after)};
  if (surface.boundary_edges == 0)
    change.volume = {enclosed_volume(before), enclosed_volume(after)};
  return change;
}

StoredNormals put_positions(std::span<const Vector3> positions, TexturedModel& model) {
  const std::vector<Vector3>& before = model.surface.mesh.positions;
  Mesh& mesh = model.model.mesh;
  bool moved = false;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const int vertex = model.surface.vertex_from_source[v];
    if (vertex < 0) continue;
    const std::size_t here = std::size_t(vertex);
    if (positions[here] == before[here]) continue;
    moved = true;
    mesh.positions[v] += positions[here] - before[here];
  }
  return moved && leave_out_normals(model.model) ? StoredNormals::left_out : StoredNormals::kept;
}

}  // namespace mq
