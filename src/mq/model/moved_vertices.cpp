#include "mq/model/moved_vertices.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "mq/base/parallel.h"
#include "mq/io/normals.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"

namespace mq {
namespace {

/// Turns each corner's normal by the smallest rotation that turns the surface's at its vertex.
void turn_normals(const Mesh& before, const Mesh& after, std::vector<Eigen::Vector3f>& normals) {
  const std::vector<Vector3> from = vertex_normals(before), to = vertex_normals(after);
  parallel_for(before.triangle_count(), [&](std::int64_t t) {
    for (int k = 0; k < 3; ++k) {
      const auto v = std::size_t(before.triangles[std::size_t(t)][std::size_t(k)]);
      if (from[v].isZero() || to[v].isZero() || from[v] == to[v]) continue;
      Eigen::Vector3f& n = normals[std::size_t(3 * t + k)];
      n = (Eigen::Quaterniond::FromTwoVectors(from[v], to[v]) * n.cast<double>()).cast<float>();
    }
  });
}

}  // namespace

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
  Mesh& mesh = model.model.mesh;
  const std::vector<Vector3>& from = model.surface.mesh.positions;
  if (std::ranges::equal(positions, from)) return false;
  const bool turns = holds_normals(model.model);
  ModelShading shading{turns ? file_frames(model.model) : CornerFrames()};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const int source = model.surface.vertex_from_source[v];
    if (source < 0) continue;
    const auto here = std::size_t(source);
    if (positions[here] == from[here]) continue;
    mesh.positions[v] += positions[here] - from[here];
  }
  if (!turns) return false;
  forget_file(model.model, Tangents::forgotten);
  shading.corners.tangents.clear();
  if (!shading.corners.normals.empty()) {
    Mesh after = model.surface.mesh;
    after.positions.assign(positions.begin(), positions.end());
    turn_normals(model.surface.mesh, after, shading.corners.normals);
  }
  model.model.shading = std::make_shared<const ModelShading>(std::move(shading));
  return true;
}

}  // namespace mq
