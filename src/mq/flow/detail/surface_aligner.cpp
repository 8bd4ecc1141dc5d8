/// Where ℓ is nearly two spacings of a coarser mesh or more, a level is worked on there (the open
/// problem of the thesis' 4.4.4): signals are averaged onto it, fields are interpolated from it,
/// turned from tangent plane to tangent plane.

#include "mq/flow/detail/surface_aligner.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/flow/detail/surface_signals.h"
#include "mq/flow/detail/transfer_weights.h"

namespace mq {
namespace {

constexpr double spacings_per_length = 1.3;  // of the mesh a scale is solved on, at least

}  // namespace

SurfaceAligner::SurfaceAligner(const FlowMeshes& meshes, const MeshFlowOptions& options,
                               const Signal& source, const Signal& target, double detail)
    : LevelAligner(options), meshes_(meshes) {
  if (options.is_factored()) {
    direct_.reserve(std::size_t(meshes.count()));
    for (int m = 0; m < meshes.count(); ++m) direct_.emplace_back(meshes[m], options.basis, options.thesis);
  }
  const bool thesis = options_.thesis.has_value();
  Signal both(source.rows(), 2 * source.cols());
  both << source, target;
  both = without_light(meshes_, both, detail, thesis ? LightOn::finest : LightOn::coarser_mesh);
  raw_.push_back({both.leftCols(source.cols()), both.rightCols(source.cols())});
  auto& [first, second] = raw_[0];
  if (thesis) {
    bring_to_scale_of(meshes_[0], first, source);
    bring_to_scale_of(meshes_[0], second, target);
  } else {
    bring_to_scale(meshes_[0], first, second);
  }
  for (int m = 0; m + 1 < meshes_.count(); ++m)
    raw_.push_back({meshes_.restricted(m, raw_[m].source), meshes_.restricted(m, raw_[m].target)});
}

void SurfaceAligner::begin(const std::vector<FlowScale>& scales) {
  LevelAligner::begin(scales);
  const auto on_finest = std::ranges::count_if(scales, [&](const FlowScale& scale) { return resolution_of_field(scale) == 0; });
  factorisations_ = int(on_finest) * (options_.thesis ? 1 : options_.steps) * most_reweightings();
}

/// The coarsest mesh on which a level shows.
int SurfaceAligner::resolution_of_field(const FlowScale& scale) const {
  int m = 0;
  while (scale.smoothed() && m + 1 < meshes_.count() &&
         meshes_[m + 1].spacing() * spacings_per_length <= scale.length)
    ++m;
  return m;
}

SurfaceField SurfaceAligner::zero(int m) const {
  return {Vector::Zero(2 * std::int64_t(meshes_[m].surface().triangle_count())),
          Vector::Zero(direct_.empty() ? 2 * std::int64_t(meshes_[m].vertex_count()) : direct_[std::size_t(m)].size())};
}

double SurfaceAligner::smoothness_of(const SurfaceField& X) const {
  return (direct_.empty() ? smoothness_energy(mesh(), X.z) : direct_[std::size_t(at_)].smoothness_energy(X.z)) /
         mesh().area();
}

SurfaceAligner::Ends SurfaceAligner::ends_along(int m, const SurfaceField& X,
                                                const std::vector<SurfacePoint>* starts) const {
  WarpEnds ends = warp_ends(meshes_[m].trace(), X.field, options_.alignment, starts);
  return {std::move(ends.source), std::move(ends.target)};
}

Signal SurfaceAligner::looked_up(int m, const Signal& signal, const std::vector<SurfacePoint>& places) const {
  return sampled(meshes_[m].surface().mesh, signal, places);
}

/// At the vertices of the coarsest mesh that has enough of them; none where that is the finest.
void SurfaceAligner::place_probes(Probes& probes) const {
  int m = 0;
  while (m + 1 < meshes_.count() && meshes_[m + 1].vertex_count() >= options_.probes) ++m;
  if (m == 0) return;
  probes.mass = meshes_[m].lumped_mass();
  for (const int v : meshes_.on_finest(m)) {
    const int corner = *meshes_[0].space().corners_begin(v);
    SurfacePoint start{corner / 3, Vector3::Zero()};
    start.barycentric[corner % 3] = 1;
    probes.starts.push_back(start);
  }
}

/// Potentials are interpolated, all other fields by way of vectors at vertices.
SurfaceField SurfaceAligner::prolongated(int m, const SurfaceField& X) const {
  const BlockTransfer& transfer = *meshes_.transfer(m - 1);
  if (direct_.empty()) return {X.field, transfer.prolongated(X.z)};
  const DirectFlowSolver& finer = direct_[std::size_t(m) - 1];
  if (options_.basis != FlowBasis::gradient) {
    Vector z = finer.coefficients_of(transfer.prolongated(meshes_[m].vertex_field(X.field)));
    Vector field = finer.field(z);
    return {std::move(field), std::move(z)};
  }
  const Signal potentials = prolongated_by_weights(transfer, Eigen::Map<const Eigen::MatrixXd>(X.z.data(), X.z.size() / 2, 2));
  Vector z(2 * potentials.rows());
  z << potentials.col(0), potentials.col(1);
  Vector field = finer.field(z);
  return {std::move(field), std::move(z)};
}

void SurfaceAligner::complete(int m, SurfaceField& X) const {
  if (direct_.empty()) X.field = meshes_[m].triangle_field(X.z);
}

FlowLevel& SurfaceAligner::enter(const FlowScale& scale) {
  MeshFlowLevel& level = levels_.emplace_back();
  length_ = scale.length;
  const int m = resolution_of_field(scale);
  move_to(m, m);
  level.vertices = mesh().vertex_count();
  const Stopwatch watch;
  const double tolerance = options_.thesis ? 1e-6 : m > 0 ? 1e-3 : 3e-3;
  const double weight = scale.smoothed() ? length_ * length_ / 2 : 0;
  const Eigen::Index channels = raw_[m].source.cols();
  Signal both(raw_[m].source.rows(), 2 * channels);
  both << raw_[m].source, raw_[m].target;
  both = smoothed(mesh(), both, weight, tolerance);
  signals_ = Pair{both.leftCols(channels), both.rightCols(channels)};
  if (options_.gradient_weight > 0 && !options_.thesis)
    for (Signal* signal : {&signals_->source, &signals_->target})
      *signal = with_slopes(mesh(), *signal, std::sqrt(options_.gradient_weight) * length_);
  level.smooth_seconds = watch.seconds();
  if (direct_.empty())
    multigrid_.emplace(meshes_.transfers_from(m), BlockMultigridOptions{.tolerance = options_.tolerance});
  return level;
}

bool SurfaceAligner::is_robust() const {
  return !options_.thesis && (options_.robust_data > 0 || options_.robust_smoothness > 0);
}

int SurfaceAligner::most_reweightings() const {
  return is_robust() ? std::max(1, options_.reweightings) : 1;
}

int SurfaceAligner::most_steps() const {
  return options_.thesis ? 1 : (at_ > 0 ? 2 : 1) * options_.steps;
}

/// Tells what factorisations on the finest mesh take; on coarser ones they are little beside them.
void SurfaceAligner::foresee(const DirectSolver& solver) const {
  if (at_ > 0 || !options_.foresee) return;
  options_.foresee({.unknowns = solver.size(),
                    .factorisations = factorisations_,
                    .seconds = solver.expected_seconds(),
                    .bytes = solver.cost().bytes});
}

/// The Y of these terms.
SurfaceField SurfaceAligner::corrected(const DataTerms& terms, double weight,
                                                const std::vector<double>& shares,
                                                const Progress& progress) {
  MeshFlowLevel& level = levels_.back();
  const DataTerms data =
      options_.thesis ? terms : terms.held(mesh().space().shapes(), mesh().area());
  if (!direct_.empty()) {
    DirectFlowSolver& direct = direct_[std::size_t(at_)];
    SurfaceField Y;
    Y.field = direct.solve(data, weight, progress, [&](const DirectSolver& solver) { foresee(solver); });
    Y.z = direct.coefficients();
    level.change.smoothness = direct.smoothness_term();
    const FlowSystemCost& cost = direct.cost();
    level.build_seconds += cost.build_seconds;
    level.solve_seconds += cost.solve_seconds();
    level.unknowns = int(cost.unknowns);
    ++level.cycles;
    return Y;
  }
  const Stopwatch building;
  VertexSystem system = vertex_system(mesh(), data, weight, shares);
  level.build_seconds += building.seconds();
  const Stopwatch solving;
  multigrid_->set_matrix(std::move(system.matrix), progress.step("levels", 0.3));
  SurfaceField Y{{}, Vector::Zero(system.right_hand_side.size())};
  level.cycles +=
      multigrid_->solve(system.right_hand_side, Y.z, progress.step("solve", 0.7)).cycles;
  level.solve_seconds += solving.seconds();
  level.unknowns = int(Y.z.size());
  Y.field = mesh().triangle_field(Y.z);
  level.change.smoothness = weight * smoothness_energy(mesh(), Y.z, shares);
  return Y;
}

/// EstimateFlow, reweighted where that is asked for; α* of it.
SurfaceField SurfaceAligner::estimate(double& scale, const Progress& progress) {
  const VertexSpace& space = mesh().space();
  const Signal difference = met_.target - met_.source;
  const Signal mean = options_.alignment == FlowAlignment::forward
                          ? met_.target
                          : Signal(0.5 * (met_.source + met_.target));
  DataTerms data = data_terms(space, difference, mean);
  const double weight = length_ * length_ * data.trace / mesh().area();
  SurfaceField Y;
  scale = 0;
  if (!(data.trace > 0)) return Y;
  const bool robust = is_robust();
  std::vector<double> shares;
  if (robust && options_.robust_data > 0) {
    const Vector nothing = Vector::Zero(2 * std::int64_t(data.triangles.size()));
    data = data_terms(space, difference, mean, options_.robust_data, &nothing);
  }
  for (int k = 0; k < most_reweightings(); ++k) {
    if (k > 0 && options_.robust_data > 0)
      data = data_terms(space, difference, mean, options_.robust_data, &Y.field);
    if (k > 0 && options_.robust_smoothness > 0 && direct_.empty())
      shares = smoothness_shares(mesh(), Y.z, options_.robust_smoothness);
    Y = corrected(data, weight, shares, progress.step("solve", 1.0 / most_reweightings()));
  }
  const auto [linear, quadratic] = data.products(Y.field);
  if (quadratic > 0) scale = -linear / quadratic;
  levels_.back().change.data = quadratic + 2 * linear;
  return Y;
}

double SurfaceAligner::correct(const Progress& progress, double share) {
  double scale = 0;
  Y_ = estimate(scale, progress.step("step", share).step("solve", direct_.empty() ? 0.8 : 0.97));
  if (scale > 0) levels_.back().scale = scale;
  return scale;
}

/// X + factor·Y.
void SurfaceAligner::advance(SurfaceField& X, double factor, const SurfaceField& Y) const {
  X.field += factor * Y.field;
  X.z += factor * Y.z;
}

/// No vector longer than its piece of the surface, on which it has nowhere to go.
void SurfaceAligner::keep_within_reach() {
  if (options_.thesis) return;
  bool shortened = false;
  const auto shorten = [&](auto&& vector, double reach) {
    const double length = vector.norm();
    if (!(length > reach)) return;
    vector *= reach / length;
    shortened = true;
  };
  if (!direct_.empty())
    for (int t = 0; t < mesh().surface().triangle_count(); ++t)
      shorten(now_.field.segment<2>(2 * std::int64_t(t)),
              mesh().reach(mesh().surface().mesh.triangles[t][0]));
  else
    for (int v = 0; v < mesh().vertex_count(); ++v)
      shorten(now_.z.segment<2>(2 * std::int64_t(v)), mesh().reach(v));
  if (!shortened) return;
  if (direct_.empty()) now_.field = mesh().triangle_field(now_.z);
  ends_ = ends_of(now_);
}

}  // namespace mq
