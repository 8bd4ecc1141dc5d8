/// From large to small lengths ℓ: signals smoothed by ½ℓ², warped along the field found so far, and
/// a correction of smoothness ℓ to it. Where ℓ is nearly two spacings of a coarser mesh or more,
/// all of that happens there (the open problem of the thesis' 4.4.4): signals are averaged onto it,
/// fields are interpolated from it, turned from tangent plane to tangent plane.

#include "mq/flow/surface_optical_flow.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/surface_levels.h"
#include "mq/flow/detail/surface_signals.h"
#include "mq/flow/surface_systems.h"
#include "mq/flow/detail/surface_warp.h"

namespace mq {

namespace {

constexpr double spacings_per_length = 1.3;  // of the mesh a scale is solved on, at least
constexpr double spacings_of_last =
    2;  // ℓ of the last scale; docs/measurements/flow.md, "The last scale"
constexpr int coarsest_vertices = 200;
constexpr double gain_worth_a_step = 0.05;
constexpr double largest_scale = 4;  // of α*

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

double positive_length(const Length& length, const SurfaceScale& scale, const char* what) {
  require(std::isfinite(length.value) && length.value >= 0,
          fmt::format("{} of {} was given; a length that is not negative was wanted", what,
                      length.value));
  return std::sqrt(weight_from_length(length, scale));
}

/// A level: ℓ, and the weight by which signals are smoothed.
struct Scale {
  double length, smoothing;
};

std::vector<Scale> scales_of(const MeshFlowOptions& options, const FlowMesh& finest) {
  const SurfaceScale scale = finest.space().scale();
  const double largest = positive_length(options.largest, scale, "a largest length");
  require(largest > 0, "the largest length must be positive");
  double smallest = positive_length(options.smallest, scale, "a smallest length");
  require(
      smallest <= largest,
      fmt::format("the smallest length, {:.4g}, is above the largest, {:.4g}", smallest, largest));
  if (smallest == 0) smallest = spacings_of_last * finest.spacing();
  std::vector<Scale> scales;
  if (options.levels > 0) {
    for (int l = 0; l < options.levels; ++l)
      scales.push_back({std::ldexp(largest, -l), std::ldexp(largest * largest / 2, -2 * l)});
    return scales;
  }
  const double shown = std::max(1.5 * smallest, 2.5 * finest.spacing());
  for (double length = largest; length > shown; length /= 2)
    scales.push_back({length, length * length / 2});
  scales.push_back({std::min(largest, smallest), 0});
  return scales;
}

/// The work on one pair.
class Aligner {
 public:
  Aligner(const FlowMeshes& meshes, const MeshFlowOptions& options)
      : options_(options), meshes_(meshes) {
    if (options.solver == FlowSolver::direct)
      direct_.emplace(meshes_[0], options.basis, options.thesis);
  }

  void take_signals(const Signal& source, const Signal& target, double detail) {
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
      raw_.push_back(
          {meshes_.restricted(m, raw_[m].source), meshes_.restricted(m, raw_[m].target)});
  }

  MeshFlow run(const std::vector<Scale>& scales, const Progress& progress) {
    MeshFlow flow;
    mesh_ = mesh_for(scales.front());
    now_.z = Vector::Zero(2 * std::int64_t(meshes_[mesh_].vertex_count()));
    now_.field = Vector::Zero(2 * std::int64_t(meshes_[mesh_].surface().triangle_count()));
    best_ = now_;
    flow.blend_error = best_error_ = error_of(0, raw_[0], {});
    if (mesh_ > 0) place_probes();
    corrections_ = int(scales.size()) * most_steps(0) * most_reweightings();
    double work = 0;
    for (const Scale& s : scales) work += meshes_[mesh_for(s)].vertex_count();
    for (const Scale& s : scales) {
      const double share = meshes_[mesh_for(s)].vertex_count() / work;
      MeshFlowLevel level =
          run_level(s, flow, progress.step(fmt::format("length {:.3g}", s.length), share));
      const Stopwatch watch;
      const double error =
          mesh_ == 0 ? error_of(0, raw_[0], ends_) : error_from_coarse(now_.z, flow.blend_error);
      astray_ = !(error < best_error_) && !options_.thesis;
      if (!astray_) {
        best_error_ = error;
        best_ = now_;
        estimated_ = mesh_ > 0 && !probes_.starts.empty();
      }
      level.error = best_error_;
      level.warp_seconds += watch.seconds();
      flow.levels.push_back(level);
    }
    move_to(0);
    if (estimated_) settle(flow, warp_ends(meshes_[0].trace(), best_.field, options_.alignment));
    flow.field = std::move(best_.field);
    return flow;
  }

 private:
  struct Pair {
    Signal source, target;
  };

  /// The coarsest mesh on which a level shows.
  int mesh_for(const Scale& s) const {
    int m = 0;
    while (s.smoothing > 0 && m + 1 < meshes_.count() &&
           meshes_[m + 1].spacing() * spacings_per_length <= s.length)
      ++m;
    return m;
  }

  Pair warped(const Pair& pair, const WarpEnds& ends) const {
    const Mesh& mesh = meshes_[mesh_].surface().mesh;
    return {sampled(mesh, pair.source, ends.source), sampled(mesh, pair.target, ends.target)};
  }

  double error_of(int m, const Pair& pair, const WarpEnds& ends) const {
    const Mesh& mesh = meshes_[m].surface().mesh;
    return mean_square_difference(meshes_[m].lumped_mass(), sampled(mesh, pair.source, ends.source),
                                  sampled(mesh, pair.target, ends.target));
  }

  /// Points of the finest mesh at which errors of fields on coarser ones are taken.
  struct Probes {
    std::vector<SurfacePoint> starts;
    Vector mass;
    double blend_error = 0;
  };

  /// At the vertices of the coarsest mesh that has enough of them; none where that is the finest.
  void place_probes() {
    int m = 0;
    while (m + 1 < meshes_.count() && meshes_[m + 1].vertex_count() >= options_.probes) ++m;
    if (m == 0) return;
    probes_.mass = meshes_[m].lumped_mass();
    for (const int v : meshes_.on_finest(m)) {
      const int corner = *meshes_[0].space().corners_begin(v);
      SurfacePoint start{corner / 3, Vector3::Zero()};
      start.barycentric[corner % 3] = 1;
      probes_.starts.push_back(start);
    }
    probes_.blend_error = probe({});
  }

  /// The error at the probes.
  double probe(const WarpEnds& ends) const {
    const Mesh& mesh = meshes_[0].surface().mesh;
    const auto at = [&](const Signal& signal, const std::vector<SurfacePoint>& points) {
      return sampled(mesh, signal, points.empty() ? probes_.starts : points);
    };
    return mean_square_difference(probes_.mass, at(raw_[0].source, ends.source),
                                  at(raw_[0].target, ends.target));
  }

  /// The error on the finest mesh of a field on a coarser one: of the blend's, the share that is
  /// left at the probes.
  double error_from_coarse(Vector z, double blend_error) const {
    for (int m = mesh_; m > 0; --m) z = meshes_.transfer(m - 1)->prolongated(z);
    const FlowMesh& finest = meshes_[0];
    const Vector field = finest.triangle_field(z);
    if (probes_.starts.empty())
      return error_of(0, raw_[0], warp_ends(finest.trace(), field, options_.alignment));
    const double left =
        probe(warp_ends(finest.trace(), field, options_.alignment, &probes_.starts));
    return probes_.blend_error > 0 ? left / probes_.blend_error * blend_error : left;
  }

  /// The error of the best field on the mesh itself, known by estimates till now: none that is
  /// above the blend's is kept, and no earlier level is said to have been better.
  void settle(MeshFlow& flow, const WarpEnds& ends) {
    estimated_ = false;
    best_error_ = error_of(0, raw_[0], ends);
    if (!(best_error_ < flow.blend_error)) {
      best_error_ = flow.blend_error;
      best_.z.setZero();
      best_.field.setZero();
    }
    for (MeshFlowLevel& level : flow.levels) level.error = std::max(level.error, best_error_);
  }

  /// X or a correction Y on the mesh at hand: per triangle, and in the vertex basis (hierarchical
  /// only).
  struct Field {
    Vector field, z;
  };

  Field corrected(const DataTerms& terms, double weight, const std::vector<double>& shares,
                  BlockMultigrid& multigrid, MeshFlowLevel& level, const Progress& progress) {
    const FlowMesh& mesh = meshes_[mesh_];
    const DataTerms data = options_.thesis ? terms : terms.held(mesh.space().shapes(), mesh.area());
    if (direct_) {
      const auto foresee = [&](const DirectSolver& solver) {
        if (options_.foresee)
          options_.foresee({.unknowns = solver.size(),
                            .factorisations = corrections_,
                            .seconds = solver.expected_seconds(),
                            .bytes = solver.cost().bytes});
      };
      Field Y{direct_->solve(data, weight, progress, foresee), {}};
      const FlowSystemCost& cost = direct_->cost();
      level.build_seconds += cost.build_seconds;
      level.solve_seconds += cost.solve_seconds();
      level.unknowns = int(cost.unknowns);
      ++level.cycles;
      return Y;
    }
    const Stopwatch building;
    VertexSystem system = vertex_system(mesh, data, weight, shares);
    level.build_seconds += building.seconds();
    const Stopwatch solving;
    multigrid.set_matrix(std::move(system.matrix), progress.step("levels", 0.3));
    Field Y{{}, Vector::Zero(system.right_hand_side.size())};
    level.cycles +=
        multigrid.solve(system.right_hand_side, Y.z, progress.step("solve", 0.7)).cycles;
    level.solve_seconds += solving.seconds();
    level.unknowns = int(Y.z.size());
    Y.field = mesh.triangle_field(Y.z);
    return Y;
  }

  bool is_robust() const {
    return !options_.thesis && (options_.robust_data > 0 || options_.robust_smoothness > 0);
  }

  int most_reweightings() const { return is_robust() ? std::max(1, options_.reweightings) : 1; }

  int most_steps(int mesh) const {
    return options_.thesis ? 1 : (mesh > 0 ? 2 : 1) * options_.steps;
  }

  /// EstimateFlow, reweighted where that is asked for.
  Field estimate(const Pair& now, double length, BlockMultigrid& multigrid, MeshFlowLevel& level,
                 double& scale, const Progress& progress) {
    const FlowMesh& mesh = meshes_[mesh_];
    const Signal difference = now.target - now.source;
    const Signal mean = options_.alignment == FlowAlignment::forward
                            ? now.target
                            : Signal(0.5 * (now.source + now.target));
    DataTerms data = data_terms(mesh.space(), difference, mean);
    const double weight = length * length * data.trace / mesh.area();
    Field Y;
    scale = 0;
    if (!(data.trace > 0)) return Y;
    const bool robust = is_robust();
    std::vector<double> shares;
    if (robust && options_.robust_data > 0) {
      const Vector nothing = Vector::Zero(2 * std::int64_t(data.triangles.size()));
      data = data_terms(mesh.space(), difference, mean, options_.robust_data, &nothing);
    }
    for (int k = 0; k < most_reweightings(); ++k) {
      if (k > 0 && options_.robust_data > 0)
        data = data_terms(mesh.space(), difference, mean, options_.robust_data, &Y.field);
      if (k > 0 && options_.robust_smoothness > 0 && !direct_)
        shares = smoothness_shares(mesh, Y.z, options_.robust_smoothness);
      Y = corrected(data, weight, shares, multigrid, level,
                    progress.step("solve", 1.0 / most_reweightings()));
    }
    const auto [linear, quadratic] = data.products(Y.field);
    if (quadratic > 0) scale = -linear / quadratic;
    return Y;
  }

  /// X + s·Y.
  void advance(const Field& Y, double s) {
    now_.field += s * Y.field;
    if (!direct_) now_.z += s * Y.z;
  }

  /// No vector longer than its piece of the surface, on which it has nowhere to go.
  void keep_within_reach() {
    const FlowMesh& mesh = meshes_[mesh_];
    bool shortened = false;
    const auto shorten = [&](auto&& vector, double reach) {
      const double length = vector.norm();
      if (!(length > reach)) return;
      vector *= reach / length;
      shortened = true;
    };
    if (direct_)
      for (int t = 0; t < mesh.surface().triangle_count(); ++t)
        shorten(now_.field.segment<2>(2 * std::int64_t(t)),
                mesh.reach(mesh.surface().mesh.triangles[t][0]));
    else
      for (int v = 0; v < mesh.vertex_count(); ++v)
        shorten(now_.z.segment<2>(2 * std::int64_t(v)), mesh.reach(v));
    if (!shortened) return;
    if (!direct_) now_.field = mesh.triangle_field(now_.z);
    ends_ = warp_ends(mesh.trace(), now_.field, options_.alignment);
  }

  /// Both fields on a finer mesh.
  void move_to(int m) {
    if (m == mesh_) return;
    for (; mesh_ > m; --mesh_)
      for (Field* X : {&now_, &best_}) X->z = meshes_.transfer(mesh_ - 1)->prolongated(X->z);
    for (Field* X : {&now_, &best_}) X->field = meshes_[m].triangle_field(X->z);
  }

  MeshFlowLevel run_level(const Scale& s, MeshFlow& flow, const Progress& progress) {
    MeshFlowLevel level;
    level.length = s.length;
    const int m = mesh_for(s);
    move_to(m);
    const FlowMesh& mesh = meshes_[m];
    level.vertices = mesh.vertex_count();
    const Stopwatch smoothing;
    const double tolerance = options_.thesis ? 1e-6 : m > 0 ? 1e-3 : 3e-3;
    const Eigen::Index channels = raw_[m].source.cols();
    Signal both(raw_[m].source.rows(), 2 * channels);
    both << raw_[m].source, raw_[m].target;
    both = smoothed(mesh, both, s.smoothing, tolerance);
    Pair signals{both.leftCols(channels), both.rightCols(channels)};
    if (options_.gradient_constancy > 0 && !options_.thesis)
      for (Signal* signal : {&signals.source, &signals.target})
        *signal = with_slopes(mesh, *signal, std::sqrt(options_.gradient_constancy) * s.length);
    level.smooth_seconds = smoothing.seconds();
    const Stopwatch warping;
    BlockMultigrid multigrid(meshes_.transfers_from(m), {.tolerance = options_.tolerance});
    bool same = !astray_;  // both fields
    if (astray_) {
      // A level that raised the error may have been on the way to a large motion: this one decides.
      const auto error_along = [&](const Field& X) {
        return error_of(m, signals, warp_ends(mesh.trace(), X.field, options_.alignment));
      };
      same = error_along(best_) <= error_along(now_);
      if (same) now_ = best_;
    }
    ends_ = warp_ends(mesh.trace(), now_.field, options_.alignment);
    if (m == 0 && estimated_)
      settle(flow, same ? ends_ : warp_ends(mesh.trace(), best_.field, options_.alignment));
    Pair now = warped(signals, ends_);
    double error = mean_square_difference(mesh.lumped_mass(), now.source, now.target);
    level.warp_seconds += warping.seconds();

    const int steps = most_steps(m);
    for (int step = 0; step < steps && error > 0; ++step) {
      double scale = 0;
      const Progress one = progress.step("step", 1.0 / steps);
      const Field Y =
          estimate(now, s.length, multigrid, level, scale, one.step("solve", direct_ ? 0.97 : 0.8));
      if (!(scale > 0)) break;
      level.scale = scale;
      if (!options_.thesis) scale = std::min(scale, largest_scale);
      const Stopwatch trying;
      const double before = error;
      for (const double part : {1.0, 0.5, 0.25}) {
        advance(Y, part * scale);
        WarpEnds ends = warp_ends(mesh.trace(), now_.field, options_.alignment);
        Pair next = warped(signals, ends);
        const double found = mean_square_difference(mesh.lumped_mass(), next.source, next.target);
        if (found < error || options_.thesis) {
          error = found;
          now = std::move(next);
          ends_ = std::move(ends);
          ++level.steps;
          break;
        }
        advance(Y, -part * scale);
      }
      level.warp_seconds += trying.seconds();
      if (!(error < (1 - gain_worth_a_step) * before)) break;
    }
    if (!options_.thesis) keep_within_reach();
    progress.at(1);
    return level;
  }

  const MeshFlowOptions& options_;
  const FlowMeshes& meshes_;
  std::optional<DirectFlowSolver> direct_;
  std::vector<Pair> raw_;  ///< prepared signals, per mesh
  int corrections_ = 0;    ///< by the direct solver, at most
  int mesh_ = 0;           ///< the one at hand
  Field now_, best_;       ///< X there, and the one of the least error on the finest mesh
  bool astray_ = false;    ///< they differ
  double best_error_ = 0;
  bool estimated_ = false;  ///< at the probes
  Probes probes_;
  WarpEnds ends_;  ///< of paths along X
};

}  // namespace

MeshFlowOptions thesis_flow(FlowBasis basis) {
  MeshFlowOptions options;
  options.basis = basis;
  options.solver = FlowSolver::direct;
  options.detail = {1e-4, Length::Unit::alpha};
  options.largest = {2 * 3e-3, Length::Unit::alpha};  // ½ℓ² = 3·10⁻³
  options.levels = 7;
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
  require(options.levels >= 0 && options.levels <= 64 && options.steps > 0,
          fmt::format("{} levels of {} steps were wanted; 0 to 64 levels of at least one step are "
                      "possible",
                      options.levels, options.steps));
  for (const double value :
       {options.robust_data, options.robust_smoothness, options.gradient_constancy})
    require(value >= 0 && std::isfinite(value),
            fmt::format("a weight of {} was given; one that is not negative was wanted", value));
  const bool hierarchical = options.solver == FlowSolver::hierarchical;
  if (hierarchical && options.basis != FlowBasis::vertex)
    throw Unsupported(
        "the hierarchical solver is for the vertex basis; take the direct solver for "
        "another");
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
  Aligner aligner(*meshes_, options_);
  const SurfaceScale scale = finest().space().scale();
  aligner.take_signals(source, target,
                       positive_length(options_.detail, scale, "a length of details"));
  const std::vector<Scale> scales = scales_of(options_, finest());
  const double prepared_in = watch.seconds();
  MeshFlow flow = aligner.run(scales, progress);
  flow.prepare_seconds = prepared_in;
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
