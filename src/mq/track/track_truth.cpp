#include "mq/track/track_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/closest_point.h"

namespace mq {

MaterialFrame material_from_uvs(const Mesh& mesh) {
  MaterialFrame frame;
  frame.space.positions = mesh.positions;
  for (const Vector2& uv : mesh.uvs) frame.material.positions.emplace_back(uv.x(), uv.y(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (!mesh.textured(t)) continue;
    frame.space.triangles.push_back(mesh.triangles[t]);
    frame.material.triangles.push_back(mesh.corner_uvs[t]);
  }
  return frame;
}

std::vector<double> drift(const std::vector<Vector3>& positions,
                          const std::vector<Vector3>& material, const MaterialFrame& frame,
                          double tolerance) {
  require(positions.size() == material.size() &&
              frame.space.triangle_count() == frame.material.triangle_count(),
          fmt::format("{} positions and {} places of material were given, {} triangles in space "
                      "and {} in the material",
                      positions.size(), material.size(), frame.space.triangle_count(),
                      frame.material.triangle_count()));
  const std::vector<ClosestPoint> found = ClosestPointFinder(frame.material)(material);
  std::vector<double> drifts(positions.size(), -1);
  parallel_for(std::ssize(positions), [&](std::int64_t v) {
    const ClosestPoint& p = found[v];
    if (p.squared_distance > tolerance * tolerance) return;
    Vector3 place = Vector3::Zero();
    for (int k = 0; k < 3; ++k) place += p.barycentric[k] * frame.space.position(p.triangle, k);
    drifts[v] = (positions[v] - place).norm();
  });
  return drifts;
}

DriftSummary summary(const std::vector<double>& drifts) {
  std::vector<double> known;
  for (const double d : drifts)
    if (d >= 0) known.push_back(d);
  DriftSummary result;
  result.known = int(known.size());
  if (known.empty()) return result;
  std::ranges::sort(known);
  for (const double d : known) result.mean += d / double(known.size());
  result.p95 = known[std::min(known.size() - 1, std::size_t(0.95 * double(known.size())))];
  result.max = known.back();
  return result;
}

}  // namespace mq
