/// Thesis chapter 3: X = ∇P, P = ½ |∇φ|², and φ is looked up where −X leads from each vertex. What
/// we do differently: paths are exact (`SurfaceFlow`), and time may be stated free of units.

#include "mq/filter/shock.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/texture_shock.h"

namespace mq {
namespace {

/// The mean over the triangles around each vertex, by area.
Vector at_vertices(const VertexSpace& space, const std::vector<double>& per_triangle) {
  Vector sum = Vector::Zero(space.size()), area = Vector::Zero(space.size());
  for (int t = 0; t < space.triangle_count(); ++t) {
    const double share = space.shapes()[t].area();
    for (const int v : space.triangles()[t]) {
      sum[v] += share * per_triangle[t];
      area[v] += share;
    }
  }
  for (Eigen::Index v = 0; v < sum.size(); ++v)
    if (area[v] > 0) sum[v] /= area[v];
  return sum;
}

/// Signals of one space smoothed by some weight; where weights are equal the solver is made once.
class Smoothing {
 public:
  Smoothing(const SignalSpace& space, const SolverFactory& factory, std::vector<SolveReport>* reports)
      : space_(space), factory_(factory), reports_(reports) {}

  Signal operator()(const Signal& values, double weight, const Progress& progress) {
    if (weight == 0) return values;
    if (!equation_)
      equation_.emplace(space_, weight, factory_, progress.step("prepare", 0.7));
    else if (equation_->weight() != weight)
      equation_->set_weight(weight, progress.step("prepare", 0.7));
    Filtered filtered = equation_->solve(values, 0.0, progress);
    if (reports_) reports_->push_back(filtered.report);
    return std::move(filtered.signal);
  }

 private:
  const SignalSpace& space_;
  const SolverFactory& factory_;
  std::vector<SolveReport>* reports_;
  std::optional<ScreenedPoisson> equation_;
};

void require_signal(const SignalSpace& space, const Signal& phi, const char* unknowns) {
  require(phi.rows() == space.size(),
          fmt::format("a signal of {} rows was given for {} {}", phi.rows(), space.size(), unknowns));
  require(phi.allFinite(), "the signal has values that are not finite");
}

}  // namespace

Vector shock_potential(const VertexSpace& space, const Signal& phi, const ShockWeights& weights,
                       const SolverFactory& factory, std::vector<SolveReport>* reports,
                       const Progress& progress) {
  require_signal(space, phi, "vertices");
  Smoothing smoothed(space, factory, reports);
  const Signal gradient =
      space.gradient(smoothed(phi, weights.signal, progress.step("smooth signal", 0.6)));
  std::vector<double> energy(space.triangle_count());
  parallel_for(space.triangle_count(), [&](std::int64_t t) {
    energy[t] = 0.5 * (gradient.row(2 * t).squaredNorm() + gradient.row(2 * t + 1).squaredNorm());
  });
  return smoothed(at_vertices(space, energy), weights.potential, progress.step("smooth potential", 0.4));
}

Vector shock_potential(const TexelSpace& space, const Signal& phi, const ShockWeights& weights,
                       const SolverFactory& factory, std::vector<SolveReport>* reports,
                       const Progress& progress) {
  require_signal(space, phi, "texels");
  const SolverFactory solver = solver_or_own(factory, space);
  Smoothing smoothed(space, solver, reports);
  std::vector<float> energy =
      space.gradient_norms(smoothed(phi, weights.signal, progress.step("smooth signal", 0.6)));
  for (float& e : energy) e *= 0.5F * e;
  require(std::ranges::all_of(energy, [](float e) { return std::isfinite(e); }),
          fmt::format("values {} apart are too large for a shock filter, which squares their slopes: scale them down",
                      phi.maxCoeff() - phi.minCoeff()));
  return smoothed(space.means_around(energy), weights.potential, progress.step("smooth potential", 0.4));
}

double potential_rate(const SignalSpace& space, const Vector& potential) {
  const Vector laplacian = space.stiffness_times(potential), mass = space.lumped_mass();
  double sum = 0, area = 0;
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    if (mass[i] > 0) {
      sum += laplacian[i] * laplacian[i] / mass[i];
      area += mass[i];
    }
  return std::sqrt(sum / area);
}

double time_from(const ShockTime& time, double rate, double area) {
  require(time.value >= 0, fmt::format("a time of {} is before the start", time.value));
  if (time.unit == ShockTime::Unit::absolute) return time.value * area * area;
  return rate > 0 ? time.value / rate : 0;
}

double time_from(const ShockTime& time, const SignalSpace& space, const Vector& potential) {
  const bool absolute = time.unit == ShockTime::Unit::absolute;
  return time_from(time, absolute ? 0 : potential_rate(space, potential), space.scale().area);
}

Shocked transport_shock(const TraceMesh& mesh, const VertexSpace& space, const Signal& signal,
                        const ShockWeights& weights, const ShockTime& time,
                        const SolverFactory& factory, const Progress& progress) {
  Shocked shocked;
  shocked.potential = shock_potential(space, signal, weights, factory, &shocked.solves,
                                      progress.step("potential", 0.7));
  shocked.rate = potential_rate(space, shocked.potential);
  shocked.time = time_from(time, space, shocked.potential);
  const Stopwatch watch;
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, shocked.potential);
  Advected advected = flow.advect(signal, shocked.time, progress.step("follow paths", 0.3));
  shocked.signal = std::move(advected.signal);
  shocked.counts = advected.counts;
  shocked.path_seconds = watch.seconds();
  return shocked;
}

}  // namespace mq
