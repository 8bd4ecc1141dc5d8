// Thesis 3.4.2. What is left open there: N per triangle is the unit mean of the three carried unit
// normals; the fit has weight 100 at unit area, the first smoothing 10⁻⁴, as in the authors' later
// program.

#include "mq/filter/geometry_shock.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/geometry_filter.h"
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

}  // namespace

SharpenedShape sharpen_shape(const Surface& surface, const GeometryShockOptions& options,
                             const SolverFactory& factory, const Progress& progress) {
  require_weight(options.normal_alpha, "normals");
  require_weight(options.signal_alpha, "the signal");
  require_weight(options.potential_alpha, "the potential");
  SharpenedShape shape;
  Stopwatch watch;
  const auto lap = [&] {
    const double seconds = watch.seconds();
    watch = Stopwatch();
    return seconds;
  };

  const FilteredNormals smooth =
      filter_normals(surface, {.weight = options.normal_alpha * surface.area, .beta = 0}, factory,
                     progress.step("smooth normals", 0.25));
  if (options.normal_alpha > 0) shape.solves.push_back(smooth.report);
  shape.seconds.smooth = lap();

  Signal normals(Eigen::Index(smooth.normals.size()), 3);
  for (std::size_t v = 0; v < smooth.normals.size(); ++v)
    normals.row(Eigen::Index(v)) = smooth.normals[v].transpose();
  const VertexSpace space(surface);
  const Vector potential = shock_potential(space, normals,
                                           {.signal = options.signal_alpha * surface.area,
                                            .potential = options.potential_alpha * surface.area},
                                           factory, &shape.solves, progress.step("potential", 0.3));
  shape.rate = potential_rate(space, potential);
  shape.time = time_from(options.time, space, potential);
  shape.seconds.potential = lap();

  const TraceMesh mesh(surface, progress);
  const Advected carried = SurfaceFlow::downhill(mesh, potential)
                               .advect(normals, shape.time, progress.step("follow paths", 0.15));
  shape.counts = carried.counts;
  shape.normals.resize(smooth.normals.size());
  parallel_for(std::ssize(shape.normals), [&](std::int64_t v) {
    const Vector3 unit = safe_unit(carried.signal.row(v).transpose());
    shape.normals[v] = unit.isZero(0) ? smooth.normals[v] : unit;
  });
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
