#include "domain.h"

#include "mq/base/error.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/reference_solver.h"
#include "mq/fem/vertex_multigrid.h"

namespace mq::app {
namespace {

template <class SolverOptions>
SolverOptions stopping(const WhenToStop& when) {
  SolverOptions options;
  options.tolerance = when.tolerance;
  options.max_cycles = when.cycles.value_or(options.max_cycles);
  return options;
}

}  // namespace

SurfaceScale Domain::scale() const {
  SurfaceScale scale = space().scale();
  if (!(scale.texel_spacing > 0)) scale.texel_spacing = std::sqrt(scale.area / space().size());
  return scale;
}

TexelDomain::TexelDomain(Run& run, const Scene& scene, const TexelSpaceOptions& options,
                         const Progress& progress)
    : space_(scene.surface, *scene.atlas, options, progress) {
  run.found(space_.defects());
  run.warn(space_.defects());
}

std::vector<Vector3> TexelDomain::places() const {
  std::vector<Vector3> places;
  places.reserve(std::size_t(space_.size()));
  for (const auto& [x, y, z] : space_.texels().positions) places.emplace_back(x, y, z);
  return places;
}

SolverFactory TexelDomain::multigrid(const WhenToStop& when) const {
  return multigrid_solver(space_.texels(), stopping<MultigridOptions>(when));
}

SolverFactory TexelDomain::reference(const WhenToStop& when) const {
  return reference_solver(space_.texels(), stopping<ReferenceOptions>(when));
}

SolverFactory VertexDomain::multigrid(const WhenToStop& when) const {
  return vertex_multigrid_solver(scene_.surface.mesh.positions, stopping<MultigridOptions>(when));
}

SolverFactory VertexDomain::reference(const WhenToStop&) const {
  throw Unsupported("--solver reference is for textures; use direct or multigrid at vertices");
}

}  // namespace mq::app
