// A front on a coarser level; log u from it; sweeps; S·δ = ∫ ⟨∇w·(1/|∇w| − 1), ∇φ_i⟩ dA by cycles, φ = w + δ.

#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/base/parallel.h"
#include "mq/filter/geodesic_steps.h"
#include "mq/filter/detail/heat_sweep.h"
#include "mq/filter/detail/level_fronts.h"
#include "mq/filter/detail/live_geodesic_ways.h"
#include "mq/linear/connected_components.h"

namespace mq {
namespace {

/// Cycles after the last sweep end when they change no distance by more than this of a spacing.
constexpr double enough_change = 0.01;

/// ... or after so many.
constexpr int most_last_cycles = 30;

/// Around a source distances are straight within so many spacings of the front's level.
constexpr double front_disc = 3;

class ProgressiveWay final : public LiveGeodesic::Way {
 public:
  using Part = LiveGeodesicStep::Part;
  using Shown = LiveGeodesicStep::Shown;

  ProgressiveWay(const LiveGeodesicSpace& on, const LiveGeodesicOptions& options, const Progress& progress)
      : space_(on.space),
        options_(options),
        spacing_(mean_spacing(on.space)),
        positions_(on.space.positions()),
        boundary_(on.space.boundary()),
        heat_(on.space.regularised_system(0, 1, progress.step("assemble", 0.2))),
        component_(connected_components(heat_)),
        poisson_(on.levels(heat_, progress.step("levels", 0.5))),
        fronts_(heat_, positions_, poisson_.hierarchy().multigrid(), options.most_front_nodes,
                progress.step("fronts", 0.3)),
        front_(on.space.size(), 1) {
    const Vector mass = on.space.lumped_mass();
    length_ = std::sqrt(options.geodesic.time) * heat_spacing(on.space, heat_, mass);
    make_heat_matrix(mass, length_ * length_, heat_);
  }

  void move(const std::vector<GeodesicSource>& sources) override {
    require_sources(sources, space_.size());
    asked_ = sources;
    next_ = Part::front;
  }

  LiveGeodesicStep step(const Progress& progress) override {
    require(!asked_.empty(), "distances need a source: none was given before the first step");
    progress.check();
    const Part part = next_;
    LiveGeodesicStep did{.part = part};
    switch (part) {
      case Part::front: run_front(), did.shown = Shown::anew, next_ = Part::misses; break;
      case Part::misses: find_misses(), next_ = Part::carry; break;
      case Part::carry: carry(); break;
      case Part::boundary: take_w(progress), next_ = Part::directions; break;
      case Part::directions: find_directions(), next_ = Part::moments; break;
      case Part::moments: find_moments(), next_ = Part::cycle; break;
      case Part::cycle: did.change = cycle(), did.shown = Shown::anew; break;
      default: break;
    }
    return did;
  }

  bool rests() const override { return next_ == Part::rest && !asked_.empty(); }

 private:
  void run_front();
  std::vector<LevelFronts::Fixed> disc(const GeodesicSource& source) const;
  void find_misses();
  void carry();
  void take_w(const Progress& progress);
  void find_directions();
  void find_moments();
  double cycle();
  bool sweeps_are_done() const { return end_.reached(options_.geodesic.max_sweeps); }

  const SignalSpace& space_;
  LiveGeodesicOptions options_;
  double spacing_, length_;
  std::vector<Vector3> positions_;
  std::vector<int> boundary_;
  SparseMatrix heat_;  ///< S while the levels are made, then M + t·S
  std::vector<int> component_;
  GuessedCycles poisson_;
  LevelFronts fronts_;
  LaneVector front_;

  std::vector<GeodesicSource> asked_;
  Part next_ = Part::rest;
  std::vector<GeodesicSource> sources_;  ///< with their discs
  Vector first_;                         ///< distances by the front
  Vector log_u_;
  std::optional<HeatSweep> sweep_;
  HeatSweepEnd end_{0};
  int next_look_ = 1, last_cycles_ = 0;
  Signal w_;
  Vector phi_;  ///< w + δ of the last cycle; empty: there was none
  std::vector<float> factor_;
};

/// The unknowns around a source that is a point, within as large a disc as is flat.
std::vector<LevelFronts::Fixed> ProgressiveWay::disc(const GeodesicSource& source) const {
  std::vector<GeodesicSource> found = {source};
  double radius = std::max(disc_spacings, front_disc * fronts_.spacing() / spacing_);
  for (; source.from; radius = std::max(disc_spacings, radius / 2)) {
    found = grown_sources(heat_, positions_, spacing_, {source}, radius);
    if (found.size() > 1 || radius <= disc_spacings) break;
  }
  std::vector<LevelFronts::Fixed> fixed;
  for (const GeodesicSource& s : found) fixed.emplace_back(s.unknown, s.distance);
  return fixed;
}

void ProgressiveWay::run_front() {
  std::vector<std::vector<LevelFronts::Fixed>> discs;
  for (const GeodesicSource& s : asked_) discs.push_back(disc(s));
  fronts_.run(discs, front_);
  std::vector<char> reached(component_.size(), 0);
  for (const GeodesicSource& s : asked_) reached[std::size_t(component_[s.unknown])] = 1;
  distance_.resize(space_.size());
  parallel_for(distance_.size(), [&](std::int64_t i) {
    distance_[i] = reached[std::size_t(component_[i])] ? std::max(0.0, double(front_.data()[i])) : infinity;
  });
  for (const auto& fixed : discs)
    for (const auto& [i, d] : fixed) distance_[i] = infinity;
  for (const auto& fixed : discs)
    for (const auto& [i, d] : fixed) distance_[i] = std::min(distance_[i], d);
  sweep_.reset();
  phi_ = Vector();
}

/// The first time it begins with what the front says.
void ProgressiveWay::find_misses() {
  if (!sweep_) {
    sources_ = grown_sources(heat_, positions_, spacing_, asked_);
    first_ = distance_;
    log_u_ = distance_ / -length_;
    std::vector<char> fixed(std::size_t(space_.size()), 0);
    for (const GeodesicSource& s : sources_) log_u_[s.unknown] = -s.distance / length_, fixed[s.unknown] = 1;
    std::vector<int> met;
    for (int i = 0; i < space_.size(); ++i)
      if (std::isfinite(first_[i])) met.push_back(i);
    sweep_.emplace(heat_, std::move(met), std::move(fixed), log_u_);
    end_ = HeatSweepEnd(options_.geodesic.tolerance);
    next_look_ = 1, last_cycles_ = 0;
  }
  end_.add(sweep_->find_misses(HeatSweep::most_tolerances * options_.geodesic.tolerance));
}

void ProgressiveWay::carry() {
  sweep_->carry();
  next_ = Part::misses;
  if (end_.sweeps() < next_look_ && !sweeps_are_done()) return;
  next_look_ = 2 * end_.sweeps();
  next_ = Part::boundary;
  if (boundary_.empty()) take_w({}), next_ = Part::directions;
}

void ProgressiveWay::take_w(const Progress& progress) {
  w_.resize(space_.size(), 1);
  parallel_for(w_.rows(), [&](std::int64_t i) { w_(i, 0) = std::isfinite(first_[i]) ? -length_ * log_u_[i] : 0; });
  if (!boundary_.empty())
    continue_to_boundary({length_, spacing_, heat_, positions_, boundary_}, sources_, first_, w_, progress);
  if (phi_.size() == 0) phi_ = w_.col(0);
  poisson_.set_guess(phi_ - w_.col(0));
}

/// 1/|∇w| − 1.
void ProgressiveWay::find_directions() {
  factor_ = gradient_lengths(space_, w_);
  for (float& f : factor_) f = 1 / f - 1;
}

void ProgressiveWay::find_moments() {
  poisson_.set_right_hand_side(space_.weighted_stiffness_times(w_, factor_).col(0));
}

double ProgressiveWay::cycle() {
  const double change = poisson_.cycle();
  phi_.resize(space_.size());
  parallel_for(phi_.size(), [&](std::int64_t i) { phi_[i] = w_(i, 0) + poisson_.x(i); });
  distance_ = phi_;
  meet_sources(sources_, component_, distance_);
  if (!sweeps_are_done())
    next_ = Part::misses;
  else
    next_ = change <= enough_change * spacing_ || ++last_cycles_ >= most_last_cycles ? Part::rest : Part::cycle;
  return change;
}

}  // namespace

std::unique_ptr<LiveGeodesic::Way> progressive_way(const LiveGeodesicSpace& space,
                                                   const LiveGeodesicOptions& options, const Progress& progress) {
  return std::make_unique<ProgressiveWay>(space, options, progress);
}

}  // namespace mq
