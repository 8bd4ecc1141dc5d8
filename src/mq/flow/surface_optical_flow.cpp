/// From large to small lengths ℓ: signals smoothed by ½ℓ², warped along the field found so far, and
/// a correction of smoothness ℓ to it. The loop is `coarse_to_fine`, the work at a level
/// `SurfaceAligner`.

#include "mq/flow/surface_optical_flow.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/detail/surface_aligner.h"
#include "mq/flow/detail/surface_scales.h"
#include "mq/flow/surface_levels.h"

namespace mq {

namespace {

constexpr double spacings_of_last = 2;  // ℓ of the last scale; docs/measurements/flow.md, "The last scale"
constexpr int coarsest_vertices = 200;

void require_signals(const Surface& surface, const Signal& source, const Signal& target) {
  require(source.rows() == surface.mesh.vertex_count() && target.rows() == source.rows() &&
              source.cols() == target.cols() && source.cols() > 0,
          fmt::format("two signals with a row for each of {} vertices and as many channels were "
                      "wanted; {} × {} and {} × {} values were given",
                      surface.mesh.vertex_count(), source.rows(), source.cols(), target.rows(),
                      target.cols()));
  for (const Signal* signal : {&source, &target})
    for (Eigen::Index v = 0; v < signal->rows(); ++v)
      require(signal->row(v).allFinite(),
              fmt::format("the {} holds a value that is not finite at vertex {}",
                          signal == &source ? "source" : "target", v));
}

}  // namespace

MeshFlowOptions thesis_flow(FlowBasis basis) {
  MeshFlowOptions options;
  options.basis = basis;
  options.solver = FlowSolver::direct;
  options.detail = {1e-4, Length::Unit::alpha};
  options.largest = {2 * 3e-3, Length::Unit::alpha};  // ½ℓ² = 3·10⁻³
  options.levels = 7;
  options.step_length = FlowStepLength::scaled;
  options.thesis = ThesisFlow{};
  if (basis == FlowBasis::gradient) options.thesis->epsilon = 5e-7;
  if (basis == FlowBasis::whitney) options.thesis->epsilon = 3e-6;
  return options;
}

std::vector<double> MeshFlow::errors() const {
  std::vector<double> all(1, blend_error);
  for (const MeshFlowLevel& level : levels) all.push_back(level.error);
  return all;
}

MeshFlowFinder::MeshFlowFinder(const Surface& surface, const MeshFlowOptions& options,
                               const Progress& progress)
    : options_(options) {
  require_options(options);
  const bool hierarchical = options.solver == FlowSolver::hierarchical;
  if (hierarchical && options.thesis)
    throw Unsupported("the thesis' weights mean another smoothness on each coarser mesh: take every scale on the mesh itself");
  meshes_ = std::make_unique<const FlowMeshes>(
      surface, hierarchical ? coarsest_vertices : std::numeric_limits<int>::max(), progress);
}

MeshFlowFinder::~MeshFlowFinder() = default;
MeshFlowFinder::MeshFlowFinder(MeshFlowFinder&&) noexcept = default;

const FlowMesh& MeshFlowFinder::finest() const { return (*meshes_)[0]; }

MeshFlow MeshFlowFinder::operator()(const Signal& source, const Signal& target,
                                    const Progress& progress) const {
  const Stopwatch watch;
  require_signals(finest().surface(), source, target);
  const SurfaceScale scale = finest().space().scale();
  SurfaceAligner aligner(*meshes_, options_, source, target,
                         flow_length(options_.detail, scale, "a length of details"));
  const std::vector<FlowScale> scales = surface_scales(options_, scale, finest().spacing(), spacings_of_last);
  const double prepared = watch.seconds();
  MeshFlow flow = surface_flow(aligner, scales, options_, progress);
  flow.prepare_seconds = prepared;
  flow.seconds = watch.seconds();
  return flow;
}

MeshFlow mesh_flow(const Surface& surface, const Signal& source, const Signal& target,
                   const MeshFlowOptions& options, const Progress& progress) {
  const Stopwatch watch;
  require_signals(surface, source, target);
  const double share_of_meshes = options.solver == FlowSolver::direct ? 0.02 : 0.3;
  const MeshFlowFinder find(surface, options, progress.step("meshes", share_of_meshes));
  const double made_in = watch.seconds();
  MeshFlow flow = find(source, target, progress.step("levels", 1 - share_of_meshes));
  flow.prepare_seconds += made_in;
  flow.seconds += made_in;
  return flow;
}

}  // namespace mq
