#include "mq/flow/detail/surface_warp.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {

WarpEnds warp_ends(const TraceMesh& mesh, const Vector& field, FlowAlignment alignment,
                   const std::vector<SurfacePoint>* starts, const Progress& progress) {
  const auto ends_along = [&](const Vector& X, double time, const Progress& step) {
    const SurfaceFlow flow = SurfaceFlow::along(mesh, X);
    return (starts ? flow.trace(*starts, time, step) : flow.trace_vertices(time, step)).ends;
  };
  if (alignment == FlowAlignment::forward)
    return {{}, ends_along(field, 1, progress.step("paths", 1))};
  WarpEnds ends;
  ends.source = ends_along(-field, 0.5, progress.step("paths", 0.5));
  ends.target = ends_along(field, 0.5, progress.step("paths", 0.5));
  return ends;
}

Signal sampled(const Mesh& mesh, const Signal& signal, const std::vector<SurfacePoint>& points) {
  if (points.empty()) return signal;
  Signal values(std::ssize(points), signal.cols());
  parallel_for(values.rows(), [&](std::int64_t v) {
    const SurfacePoint& p = points[v];
    if (p.triangle < 0) {
      values.row(v) = signal.row(v);
      return;
    }
    const Triangle& corners = mesh.triangles[p.triangle];
    values.row(v) = interpolate(p.barycentric, [&](int k) { return signal.row(corners[k]); });
  });
  return values;
}

double mean_square_difference(const Vector& lumped_mass, const Signal& a, const Signal& b) {
  const Eigen::Array2d sum =
      parallel_sum(a.rows(), Eigen::Array2d(0, 0), [&](std::int64_t begin, std::int64_t end) {
        Eigen::Array2d part(0, 0);
        for (std::int64_t v = begin; v < end; ++v)
          part += lumped_mass[v] * Eigen::Array2d((a.row(v) - b.row(v)).squaredNorm(), 1);
        return part;
      });
  return sum[0] / (sum[1] * double(std::max<Eigen::Index>(1, a.cols())));
}

WarpedPair warp_pair(const TraceMesh& mesh, const Vector& field, const Signal& source,
                     const Signal& target, double t, const Progress& progress) {
  require(t >= 0 && t <= 1, fmt::format("a time between 0 and 1 was wanted, {} was given", t));
  require(source.rows() == target.rows() && source.cols() == target.cols(),
          fmt::format("signals of {} × {} and {} × {} values do not meet", source.rows(),
                      source.cols(), target.rows(), target.cols()));
  return {
      t == 0
          ? source
          : SurfaceFlow::along(mesh, -field).advect(source, t, progress.step("source", 0.5)).signal,
      t == 1 ? target
             : SurfaceFlow::along(mesh, field)
                   .advect(target, 1 - t, progress.step("target", 0.5))
                   .signal};
}

Signal interpolate(const TraceMesh& mesh, const Vector& field, const Signal& source,
                   const Signal& target, double t, const Progress& progress) {
  if (t == 0) return source;
  if (t == 1) return target;
  const WarpedPair warped = warp_pair(mesh, field, source, target, t, progress);
  return (1 - t) * warped.source + t * warped.target;
}

}  // namespace mq
