#include "mq/flow/cut_texture_flow.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/fem/flat_triangle.h"
#include "mq/flow/detail/vertex_means.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

/// At the peak for a vertex of the triangles cut, three channels aligned by multigrid
/// (docs/measurements/flow.md).
constexpr double bytes_per_vertex = 2900;

/// The edges' bound, where there is memory for what it leads to.
double affordable_edge(double longest_edge, const TexelSpace& space) {
  require(longest_edge > 0,
          fmt::format("a longest edge above 0 was wanted, {} was given", longest_edge));
  require_memory(
      std::int64_t(bytes_per_vertex * expected_vertices(space.size(), longest_edge)),
      fmt::format("aligning {} texels", space.size()),
      fmt::format("use smaller textures, or allow longer edges ({})", option_name("longest_edge")));
  return longest_edge;
}

/// Of the work, what this takes of it where multigrid aligns: beside factorisations it is little.
double share_beside(const MeshFlowOptions& options, double share) {
  return options.is_factored() ? 0.1 * share : share;
}

/// Up to here what lies between vertices is hardly narrower than a texel, and values there say it
/// all.
constexpr double fine_edge = 2;

}  // namespace

CutTextureFlow::CutTextureFlow(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                               const Signal& source, const Signal& target, const MeshFlowOptions& options,
                               double longest_edge, const Progress& progress)
    : source_(surface),
      refined_(surface, atlas, space, affordable_edge(longest_edge, space),
               progress.step("cut triangles", share_beside(options, 0.05))),
      flow_([&] {
        require(
            source.rows() == space.size() && target.rows() == space.size() &&
                source.cols() == target.cols(),
            fmt::format("two signals of {} texels are wanted; found {} x {} and {} x {} values",
                        space.size(), source.rows(), source.cols(), target.rows(), target.cols()));
        const auto sampled = [&](const Signal& signal) {
          return longest_edge > fine_edge ? means_at_vertices(refined_, signal)
                                                  : refined_.at_vertices(signal);
        };
        return mesh_flow(refined_.fine().surface, sampled(source), sampled(target), options,
                         progress.step("align", 1 - share_beside(options, 0.2)));
      }()),
      mesh_(refined_.fine().surface, progress.step("order triangles", share_beside(options, 0.05))),
      starts_(refined_.starts(progress.step("place texels", share_beside(options, 0.1)))) {}

Signal CutTextureFlow::looked_up(const Signal& signal, double time, const Progress& progress) const {
  if (time == 0) return signal;
  const Vector along = time < 0 ? Vector(-flow_.field) : flow_.field;
  const Traced traced = SurfaceFlow::along(mesh_, along).trace(starts_, std::abs(time), progress);
  const Eigen::RowVectorXd low = signal.colwise().minCoeff(), high = signal.colwise().maxCoeff();
  Signal values = signal;
  parallel_for(signal.rows(), [&](std::int64_t i) {
    const SurfacePoint &from = starts_[std::size_t(i)], &to = traced.ends[std::size_t(i)];
    if (to.triangle == from.triangle && to.barycentric == from.barycentric) return;
    Signal change(2, signal.cols());
    refined_.value(signal, to, change.row(0));
    refined_.value(signal, from, change.row(1));
    values.row(i) = (signal.row(i) + change.row(0) - change.row(1)).cwiseMax(low).cwiseMin(high);
  });
  return values;
}

WarpedPair CutTextureFlow::warp_pair(const Signal& source, const Signal& target, double t,
                                  const Progress& progress) const {
  require(t >= 0 && t <= 1, fmt::format("a time between 0 and 1 was wanted, {} was given", t));
  return {looked_up(source, -t, progress.step("source", 0.5)),
          looked_up(target, 1 - t, progress.step("target", 0.5))};
}

TangentField CutTextureFlow::field() const {
  const Surface& fine = refined_.fine().surface;
  const std::vector<Vector3> parts = field_in_space(fine, flow_.field);
  const std::vector<FlatTriangle> shapes = flat_triangles(fine);
  TangentField sum(source_.mesh.triangles.size(), Vector3::Zero());
  std::vector<double> area(sum.size(), 0.0);
  for (std::size_t t = 0; t < parts.size(); ++t) {
    const std::size_t whole = std::size_t(refined_.fine().source[t]);
    sum[whole] += shapes[t].area() * parts[t];
    area[whole] += shapes[t].area();
  }
  for (std::size_t t = 0; t < sum.size(); ++t)
    if (area[t] > 0) sum[t] /= area[t];
  return sum;
}

}  // namespace mq
