#pragma once
/// Signals on surfaces, and the same moved along.

#include <cmath>
#include <functional>

#include <Eigen/Geometry>

#include "fixtures.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/sample/noise.h"
#include "mq/trace/surface_flow.h"

namespace mq::fixtures {

inline constexpr FlowBasis bases[] = {FlowBasis::vertex, FlowBasis::triangle, FlowBasis::gradient,
                                      FlowBasis::whitney};

/// Two signals of three channels on one surface, the second the first moved along.
struct Pair {
  Surface surface;
  Signal source, target;
  double spacing = 0;
};

using Motion = std::function<Vector3(const Vector3&)>;

/// Three channels of smooth noise at a place.
inline Eigen::RowVector3d colour_at(const Vector3& p) {
  static const Noise noise(7);
  const Vector3 apart(31.4, 7.3, 3.7);
  return {noise(p), noise(p + apart), noise(p + 2 * apart)};
}

inline Signal colours(const Surface& surface, double scale, const Motion& back) {
  Signal values(surface.mesh.vertex_count(), 3);
  for (int v = 0; v < values.rows(); ++v) values.row(v) = colour_at(scale * back(surface.mesh.positions[v]));
  return values;
}

inline Pair moved(const Mesh& mesh, double scale, const Motion& back) {
  Pair pair{make_surface(mesh), {}, {}, 0};
  pair.source = colours(pair.surface, scale, [](const Vector3& p) { return p; });
  pair.target = colours(pair.surface, scale, back);
  pair.spacing = std::sqrt(2 / std::sqrt(3.0) * pair.surface.area / mesh.vertex_count());
  return pair;
}

inline Motion rotation(double angle, const Vector3& axis) {
  return [turn = Eigen::AngleAxisd(-angle, axis.normalized())](const Vector3& p) {
    return Vector3(turn * p);
  };
}

/// How far the ends of paths along X are from where their vertices truly go: the mean, in spacings.
inline double end_point_error(const Pair& pair, const Vector& field, const Motion& truth) {
  const TraceMesh mesh(pair.surface);
  const auto ends = SurfaceFlow::along(mesh, field).trace_vertices(1).ends;
  double sum = 0;
  for (std::size_t v = 0; v < ends.size(); ++v) {
    Vector3 end = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      end += ends[v].barycentric[k] * pair.surface.mesh.position(ends[v].triangle, k);
    sum += (end - truth(pair.surface.mesh.positions[v])).norm();
  }
  return sum / double(ends.size()) / pair.spacing;
}

inline Pair turned_torus(double spacings, int n = 90) {
  const double spacing = std::sqrt(2 / std::sqrt(3.0) * 0.4 * 39.5 / (n * (n / 2)));
  return moved(torus(n, n / 2), 2, rotation(spacings * spacing, Vector3::UnitZ()));
}

inline Pair turned_sphere(double angle) {
  return moved(sphere(5), 2, rotation(angle, Vector3(0.2, 0.3, 1)));
}

inline MeshFlowOptions from(double percent) {
  MeshFlowOptions options;
  options.largest = {percent, Length::Unit::percent};
  options.detail = {0, Length::Unit::percent};
  return options;
}

inline Vector3 around_z(const Vector3& p) { return Vector3::UnitZ().cross(p); }

}  // namespace mq::fixtures
