#include "mq/flow/texture_flow.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/detail/surface_scales.h"
#include "mq/flow/detail/texture_aligner.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

/// ℓ of the last scale: less would follow the noise of photographs (docs/measurements/flow.md, "Textures").
constexpr double texels_of_last = 4;
constexpr int coarsest_texels = 500;

/// At the peak for a texel, three channels aligned (docs/measurements/flow.md).
constexpr double bytes_per_texel = 1700;

MeshFlow aligned(const FlowTextures& textures, const Signal& source, const Signal& target,
                 const MeshFlowOptions& options, const Progress& progress) {
  const Stopwatch watch;
  const SurfaceScale scale = textures[0].space().scale();
  TextureAligner aligner(textures, options, source, target, flow_length(options.detail, scale, "a length of details"));
  const std::vector<FlowScale> scales = surface_scales(options, scale, textures[0].spacing(), texels_of_last);
  const double prepared = watch.seconds();
  MeshFlow flow = surface_flow(aligner, scales, options, progress);
  flow.prepare_seconds = prepared;
  flow.seconds = watch.seconds();
  return flow;
}

/// All that must hold before anything is made.
const TexelSpace& checked(const TexelSpace& space, const Signal& source, const Signal& target,
                          const MeshFlowOptions& options) {
  require(source.rows() == space.size() && target.rows() == space.size() && source.cols() == target.cols() &&
              source.cols() > 0,
          fmt::format("two signals of {} texels are wanted; found {} x {} and {} x {} values", space.size(),
                      source.rows(), source.cols(), target.rows(), target.cols()));
  require(source.allFinite() && target.allFinite(), "the textures have values that are not finite");
  require_options(options);
  if (options.basis != FlowBasis::vertex || options.solver != FlowSolver::hierarchical || options.thesis)
    throw Unsupported("fields of texels are found by multigrid alone; cut the triangles for another basis or solver");
  require_memory(std::int64_t(bytes_per_texel * space.size()), fmt::format("aligning {} texels", space.size()),
                 "use smaller textures");
  return space;
}

}  // namespace

TextureFlow::TextureFlow(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Signal& source,
                         const Signal& target, const MeshFlowOptions& options, const Progress& progress)
    : textures_(surface, atlas, checked(space, source, target, options), coarsest_texels,
                progress.step("textures", 0.15)),
      flow_(aligned(textures_, source, target, options, progress.step("align", 0.85))) {}

Signal TextureFlow::looked_up(const Signal& signal, double time, const Progress& progress) const {
  if (time == 0) return signal;
  const FlowTexture& finest = textures_[0];
  std::vector<std::array<double, 2>> field = velocities();
  for (auto& [x, y] : field) x *= std::copysign(1, time), y *= std::copysign(1, time);
  const std::vector<ChartPlace>& starts = finest.starts().places;
  const TracedTexels traced = AtlasFlow::along(finest.domain(), field).trace(starts, std::abs(time), progress);
  const Eigen::RowVectorXd low = signal.colwise().minCoeff(), high = signal.colwise().maxCoeff();
  Signal values = signal;
  parallel_for(signal.rows(), [&](std::int64_t i) {
    const ChartPlace &from = starts[std::size_t(i)], &to = traced.ends[std::size_t(i)];
    if (from == to) return;
    Signal change(2, signal.cols());
    finest.domain().sharp_value(signal, to, change.row(0));
    finest.domain().sharp_value(signal, from, change.row(1));
    values.row(i) = (signal.row(i) + change.row(0) - change.row(1)).cwiseMax(low).cwiseMin(high);
  });
  return values;
}

WarpedPair TextureFlow::warp_pair(const Signal& source, const Signal& target, double t, const Progress& progress) const {
  require(t >= 0 && t <= 1, fmt::format("a time between 0 and 1 was wanted, {} was given", t));
  return {looked_up(source, -t, progress.step("source", 0.5)), looked_up(target, 1 - t, progress.step("target", 0.5))};
}

}  // namespace mq
