// Thesis 3.4.2. What is left open there: N per triangle, and the fit's weight, which is 100 at unit
// area as in the authors' later program. What we do differently: paths begin in triangles and carry
// the triangles' own normals, where the thesis carries those at vertices, whose means over a triangle
// are not its own normal: fitted to them a cube loses its edges before anything has moved.

#include "mq/filter/geometry_shock.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/detail/vector_signal.h"
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

/// Calls visit(t) for the triangles, by the mesh's numbers, that a point lies in: one, the two of an
/// edge, or those around a vertex.
template <class Visit>
void around(const TraceMesh& mesh, const SurfacePoint& point, const Visit& visit) {
  const int t = mesh.trace_triangle(point.triangle);
  const Vector3& b = point.barycentric;
  for (int k = 0; k < 3; ++k)
    if (b[(k + 1) % 3] == 0 && b[(k + 2) % 3] == 0) {
      const int v = mesh.corners(t)[k];
      for (const int* corner = mesh.corners_begin(v); corner != mesh.corners_end(v); ++corner)
        visit(*corner / 3);
      return;
    }
  visit(t);
  for (int k = 0; k < 3; ++k)
    if (b[k] == 0 && mesh.across(t, k) >= 0) visit(mesh.across(t, k) >> 2);
}

/// Weights of the middles of a triangle's thirds, where its paths begin: near one corner, far from two.
constexpr double near = 2.0 / 3, far = 1.0 / 6;

/// 0 to rounding: normals that a triangle would have to turn to by a right angle or more.
constexpr double least_cosine = 1e-9;

/// Per triangle the mean of the normals in which three paths from it end. Of triangles that meet
/// where a path ends it is the one whose normal is nearest to that of its beginning: a path that ends
/// on a crease stays on its side of it. A path that crossed one and found a normal at a right angle
/// or more counts as one that has stayed: (3.9) would shrink the triangle to nothing, or fold it.
std::vector<Vector3> carried(const SurfaceFlow& flow, const std::vector<Vector3>& normals,
                             double time, PathCounts& counts, const Progress& progress) {
  const TraceMesh& mesh = flow.mesh();
  std::vector<Vector3> sums(normals.size(), Vector3::Zero());
  std::vector<SurfacePoint> starts(normals.size());
  for (int k = 0; k < 3; ++k) {
    parallel_for(std::ssize(starts), [&](std::int64_t t) {
      starts[t] = {int(t), Vector3::Constant(far)};
      starts[t].barycentric[k] = near;
    });
    const Traced traced = flow.trace(starts, time, progress.step("paths", 1.0 / 3));
    counts = counts + traced.counts;
    parallel_for(std::ssize(sums), [&](std::int64_t t) {
      const Vector3& own = normals[t];
      const Vector3* found = &own;
      double nearest = -2;
      around(mesh, traced.ends[t], [&](int other) {
        const Vector3& n = normals[mesh.source_triangle(other)];
        if (n.dot(own) <= nearest) return;
        nearest = n.dot(own);
        found = &n;
      });
      sums[t] += nearest > least_cosine ? *found : own;
    });
  }
  // Three times the same is that, bit for bit.
  parallel_for(std::ssize(sums), [&](std::int64_t t) {
    const Vector3 mean = safe_unit(sums[t]);
    sums[t] = mean.isZero(0) || sums[t] == 3 * normals[t] ? normals[t] : mean;
  });
  return sums;
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

  const VertexSpace space(surface);
  std::optional<Smoother> smoothed(std::in_place, space, factory, shape.solves);
  const std::vector<Vector3> found = vertex_normals(surface.mesh);
  const std::vector<Vector3> smooth = unit_rows(
      (*smoothed)(as_signal(found), options.normal_alpha, progress.step("smooth normals", 0.25)),
      found);
  shape.seconds.smooth = lap();

  const std::vector<Vector3> normals =
      filtered_with(space, triangle_normals(surface.mesh),
                    {found, smooth, options.normal_alpha * space.scale().area, 0});
  Vector potential = shock_potential(
      space, (*smoothed)(as_signal(smooth), options.signal_alpha, progress.step("smooth signal", 0.15)), {});
  potential = (*smoothed)(potential, options.potential_alpha,
                          progress.step("smooth potential", 0.15));
  smoothed.reset();
  shape.rate = potential_rate(space, potential);
  shape.time = time_from(options.time, space, potential);
  shape.seconds.potential = lap();

  const TraceMesh mesh(surface, progress.step("order triangles", 0.05));
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, potential);
  shape.normals = carried(flow, normals, shape.time, shape.counts,
                          progress.step("follow paths", 0.1));
  shape.seconds.paths = lap();

  const NormalFit fit(surface, options.fit_alpha, factory, progress.step("prepare fit", 0.2));
  shape.seconds.prepare_fit = lap();
  Reshaped fitted = fit.fit(shape.normals, options.fit_steps,
                            progress.step("fit", 0.1));
  shape.solves.push_back(fitted.report);
  shape.positions = std::move(fitted.positions);
  shape.potential = std::move(potential);
  shape.seconds.fit = lap();
  shape.seconds.solver = solver_seconds(shape.solves);
  return shape;
}

}  // namespace mq
