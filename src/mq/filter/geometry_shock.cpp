// Thesis 3.4.2. What is left open there: N per triangle is the unit mean of the three carried unit
// normals; the fit has weight 100 at unit area, the first smoothing 10⁻⁴, as in the authors' later
// program.

#include "mq/filter/geometry_shock.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

void require_weight(double alpha, const char* what) {
  require(alpha >= 0 && std::isfinite(alpha),
          fmt::format("the smoothing of {} is {}; it must be finite and not negative", what, alpha));
}

/// In making solvers and solving. Solutions that share a solver each report its set-up.
double solver_seconds(const std::vector<SolveReport>& solves) {
  double sum = 0, last_setup = -1;
  for (const SolveReport& report : solves) {
    sum += report.solve_seconds + (report.setup_seconds == last_setup ? 0 : report.setup_seconds);
    last_setup = report.setup_seconds;
  }
  return sum;
}

Signal as_signal(const std::vector<Vector3>& vectors) {
  Signal signal(Eigen::Index(vectors.size()), 3);
  for (std::size_t v = 0; v < vectors.size(); ++v)
    signal.row(Eigen::Index(v)) = vectors[v].transpose();
  return signal;
}

/// Rows scaled to length 1; those of `before` where that is not possible.
std::vector<Vector3> unit_rows(const Signal& signal, const std::vector<Vector3>& before) {
  std::vector<Vector3> units(before.size());
  parallel_for(std::ssize(units), [&](std::int64_t v) {
    const Vector3 unit = safe_unit(signal.row(v).transpose());
    units[v] = unit.isZero(0) ? before[v] : unit;
  });
  return units;
}

/// Smooths signals of one space with one solver, made when it is first needed and then told of other
/// weights.
class Smoother {
 public:
  Smoother(const VertexSpace& space, const SolverFactory& factory, std::vector<SolveReport>& solves)
      : space_(space), factory_(factory), solves_(solves) {}

  Signal operator()(Signal signal, double alpha, const Progress& progress) {
    if (alpha == 0) return signal;
    const double weight = alpha * space_.scale().area;
    const Progress prepare = progress.step("prepare", 0.6);
    if (!equation_)
      equation_.emplace(space_, weight, factory_, prepare);
    else if (equation_->weight() != weight)
      equation_->set_weight(weight, prepare);
    Filtered smooth = equation_->solve(signal, 0.0, progress.step("solve", 0.4));
    solves_.push_back(std::move(smooth.report));
    return std::move(smooth.signal);
  }

 private:
  const VertexSpace& space_;
  const SolverFactory& factory_;
  std::vector<SolveReport>& solves_;
  std::optional<ScreenedPoisson> equation_;
};

}  // namespace

SharpenedShape sharpen_shape(const Surface& surface, const GeometryShockOptions& options,
                             const SolverFactory& factory, const Progress& progress) {
  require_weight(options.normal_alpha, "normals");
  require_weight(options.signal_alpha, "the signal");
  require_weight(options.potential_alpha, "the potential");
  SharpenedShape shape;
  if (options.time.value == 0) {
    shape.positions = surface.mesh.positions;
    shape.normals = vertex_normals(surface.mesh);
    shape.solves.push_back({.method = "none (nothing to change)", .residuals = {}});
    return shape;
  }
  Stopwatch watch;
  const auto lap = [&] {
    const double seconds = watch.seconds();
    watch = Stopwatch();
    return seconds;
  };

  const VertexSpace space(surface);
  std::optional<Smoother> smoothed(std::in_place, space, factory, shape.solves);
  const std::vector<Vector3> found = vertex_normals(surface.mesh);
  const std::vector<Vector3> smooth = unit_rows(
      (*smoothed)(as_signal(found), options.normal_alpha, progress.step("smooth normals", 0.25)),
      found);
  shape.seconds.smooth = lap();

  const Signal normals = as_signal(smooth);
  Vector potential = shock_potential(
      space, (*smoothed)(normals, options.signal_alpha, progress.step("smooth signal", 0.15)), {});
  potential = (*smoothed)(potential, options.potential_alpha,
                          progress.step("smooth potential", 0.15));
  smoothed.reset();
  shape.rate = potential_rate(space, potential);
  shape.time = time_from(options.time, space, potential);
  shape.seconds.potential = lap();

  const TraceMesh mesh(surface, progress.step("order triangles", 0.05));
  const Advected carried = SurfaceFlow::downhill(mesh, potential)
                               .advect(normals, shape.time, progress.step("follow paths", 0.1));
  shape.counts = carried.counts;
  shape.normals = unit_rows(carried.signal, smooth);
  shape.seconds.paths = lap();

  const NormalFit fit(surface, options.fit_alpha, factory, progress.step("prepare fit", 0.2));
  shape.seconds.prepare_fit = lap();
  Reshaped fitted = fit.fit(triangle_means(surface.mesh, shape.normals), options.fit_steps,
                            progress.step("fit", 0.1));
  shape.solves.push_back(fitted.report);
  shape.positions = std::move(fitted.positions);
  shape.seconds.fit = lap();
  shape.seconds.solver = solver_seconds(shape.solves);
  return shape;
}

}  // namespace mq
