#include "mq/baseline/cut_texture_shock.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/refined_texture.h"

namespace mq {
namespace {

/// At the peak, while the potential is smoothed by multigrid, for a vertex of the triangles cut:
/// beside what is there before, and beside that and the triangles themselves. Measured:
/// docs/measurements/paths.md.
constexpr double bytes_per_vertex = 760, bytes_per_vertex_once_cut = 640;

void require_memory_for(double bytes, int texels) {
  require_memory(std::int64_t(bytes), fmt::format("following paths from {} texels", texels),
                 fmt::format("use a smaller texture, or allow longer edges ({})",
                             option_name("longest_edge")));
}

/// Where the texel's own value is not the signal's at the start of its path, as outside charts, the
/// difference fades over the first texel of the way.
void look_up(const RefinedTexture& refined, const TexelSpace& space, const Signal& signal,
             const std::vector<SurfacePoint>& starts, const std::vector<SurfacePoint>& ends,
             Signal& result) {
  const double side = space.scale().texel_spacing;
  parallel_for(signal.rows(), [&](std::int64_t i) {
    const SurfacePoint &from = starts[i], &to = ends[i];
    if (to.triangle == from.triangle && to.barycentric == from.barycentric) return;
    auto row = result.middleRows(i, 1);
    refined.value(signal, to, row);
    const double left = 1 - (refined.place(to) - refined.place(from)).norm() / side;
    if (!(left > 0)) return;
    Signal before(1, signal.cols());
    refined.value(signal, from, before);
    for (Eigen::Index c = 0; c < signal.cols(); ++c) {
      const double own = signal(i, c), found = row(0, c);
      const auto [low, high] = std::minmax(own, found);
      row(0, c) = std::clamp(found + left * (own - before(0, c)), low, high);
    }
  });
}

}  // namespace

double usual_longest_edge(int texels) {
  constexpr double vertices = 1.5e6;
  return std::clamp(std::sqrt(expected_vertices(texels, 1) / vertices), 0.7, 1.4);
}

CutShockedTexture cut_texture_shock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                                    const Signal& signal, const CutTextureShockOptions& options,
                                    const Progress& progress) {
  require(signal.rows() == space.size(),
          fmt::format("a signal of {} rows was given for {} texels", signal.rows(), space.size()));
  require(signal.allFinite(), "the texture has values that are not finite");
  require_memory_for(bytes_per_vertex * expected_vertices(space.size(), options.longest_edge),
                     space.size());
  const RefinedTexture refined(surface, atlas, space, options.longest_edge, progress.step("cut triangles", 0.15));
  const Surface& fine = refined.fine().surface;
  require_memory_for(bytes_per_vertex_once_cut * fine.mesh.vertex_count(), space.size());
  CutShockedTexture shocked;
  shocked.vertices = fine.mesh.vertex_count();
  Vector P;
  {
    const VertexSpace vertices(fine);
    P = shock_potential(vertices, refined.at_vertices(signal), options.weights,
                        vertex_multigrid_solver(fine.mesh.positions), &shocked.solves,
                        progress.step("potential", 0.4));
    shocked.rate = potential_rate(vertices, P);
    shocked.time = time_from(options.time, shocked.rate, vertices.scale().area);
  }
  // Ordered only now: the solver needs more memory than all else.
  const TraceMesh mesh(fine, progress.step("order triangles", 0.1));
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  const std::vector<SurfacePoint> starts = refined.starts(progress.step("place texels", 0.15));
  const Stopwatch watch;
  const Traced traced = flow.trace(starts, shocked.time, progress.step("follow paths", 0.2));
  shocked.counts = traced.counts;
  shocked.path_seconds = watch.seconds();
  shocked.signal = signal;
  if (shocked.time > 0) look_up(refined, space, signal, starts, traced.ends, shocked.signal);
  return shocked;
}

}  // namespace mq
