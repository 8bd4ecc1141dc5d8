/// Until paths can be followed in the texture itself, they run on triangles no larger than texels.

#include "mq/filter/texture_shock.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/refined_texture.h"

namespace mq {
namespace {

/// At the peak, while the potential is smoothed by multigrid, for a vertex of the triangles cut:
/// beside what is there before, and beside that and the triangles themselves. Measured:
/// docs/performance.md, "Paths".
constexpr double bytes_per_vertex = 760, bytes_per_vertex_once_cut = 640;

void require_memory_for(double bytes, int texels) {
  require_memory(std::int64_t(bytes), fmt::format("following paths from {} texels", texels),
                 "use a smaller texture, or allow longer edges (--longest-edge)");
}

}  // namespace

ShockedTexture texture_shock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                             const Signal& signal, const TextureShockOptions& options,
                             const Progress& progress) {
  require(signal.rows() == space.size(),
          fmt::format("a signal of {} rows was given for {} texels", signal.rows(), space.size()));
  require(signal.allFinite(), "the texture has values that are not finite");
  require_memory_for(bytes_per_vertex * expected_vertices(space.size(), options.longest_edge),
                     space.size());
  const RefinedTexture refined(surface, atlas, space, options.longest_edge,
                               progress.step("cut triangles", 0.15));
  ShockedTexture shocked;
  shocked.vertices = refined.fine().surface.mesh.vertex_count();
  require_memory_for(bytes_per_vertex_once_cut * shocked.vertices, space.size());
  Vector P;
  {
    const VertexSpace vertices(refined.fine().surface);
    P = shock_potential(vertices, refined.at_vertices(signal), options.weights,
                        options.solver(refined.fine().surface.mesh.positions), &shocked.solves,
                        progress.step("potential", 0.35));
    shocked.rate = potential_rate(vertices, P);
    shocked.time = time_from(options.time, vertices, P);
  }
  // Ordered only now: the solver needs more memory than all else.
  const TraceMesh mesh(refined.fine().surface, progress.step("order triangles", 0.1));
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  const std::vector<SurfacePoint> starts = refined.starts(progress.step("place texels", 0.15));
  const Stopwatch watch;
  const Traced traced = flow.trace(starts, shocked.time, progress.step("follow paths", 0.2));
  shocked.counts = traced.counts;
  shocked.path_seconds = watch.seconds();
  shocked.signal = signal;
  parallel_for(signal.rows(), [&](std::int64_t i) {
    const SurfacePoint &from = starts[i], &to = traced.ends[i];
    if (to.triangle == from.triangle && to.barycentric == from.barycentric) return;
    refined.value(signal, to, shocked.signal.middleRows(i, 1));
  });
  progress.at(1);
  return shocked;
}

}  // namespace mq
