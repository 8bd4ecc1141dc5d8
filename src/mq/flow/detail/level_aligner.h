#pragma once
/// What aligning two signals level by level is on any surface, at vertices or in texels.

#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "mq/base/stopwatch.h"
#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/surface_warp.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/linear/block_multigrid.h"

namespace mq {

/// The surface as `coarse_to_fine` sees it, in so many resolutions, number 0 the finest: each level is worked on at the
/// coarsest that shows it, and X may live on a coarser one than the signals. A `Field` is X on the resolution at hand, a
/// `Place` where a signal is looked up. See `MeshFlow` for what errors are.
template <class Field, class Place>
class LevelAligner : public FlowDomain {
 public:
  std::string name(const FlowScale& scale) const final { return fmt::format("length {:.3g}", scale.length); }
  double work(const FlowScale& scale) const final { return double(masses(resolution_of_signals(scale)).size()); }
  double blend_error() const final { return blend_error_; }
  double level_error() const final { return error_; }

  void go_back_if_better() final {
    const Stopwatch watch;
    ends_ = ends_of(now_);
    Ends of_best = ends_of(best_);
    same_ = error_of(seen_, signals(), of_best) <= error_of(seen_, signals(), ends_);
    if (same_) {
      now_ = best_;
      ends_ = std::move(of_best);
    }
    followed_ = true;
    levels_.back().warp_seconds += watch.seconds();
  }

  void look_up() final {
    const Stopwatch watch;
    if (!followed_) ends_ = ends_of(now_);
    followed_ = false;
    met_ = warped(signals(), ends_);
    error_ = mean_square_difference(masses(seen_), met_.source, met_.target);
    levels_.back().warp_seconds += watch.seconds();
  }

  FlowErrorChange attempt(double factor) final {
    const Stopwatch watch;
    factor_ = factor;
    advance(now_, factor, Y_);
    next_ends_ = ends_of(now_);
    next_ = warped(signals(), next_ends_);
    next_error_ = mean_square_difference(masses(seen_), next_.source, next_.target);
    levels_.back().warp_seconds += watch.seconds();
    return {error_, next_error_};
  }
  void take() final {
    error_ = next_error_;
    met_ = std::move(next_);
    ends_ = std::move(next_ends_);
  }
  void leave() final {
    advance(now_, -factor_, Y_);
    next_ = {};
    next_ends_ = {};
  }

  double measure() final {
    keep_within_reach();
    levels_.back().smoothness = smoothness_of(now_);
    const Stopwatch watch;
    const double error = seen_ == 0 ? error_of(0, raw_[0], ends_) : error_from_coarse();
    same_ = false;
    levels_.back().warp_seconds += watch.seconds();
    return error;
  }
  void keep() final {
    best_ = now_;
    same_ = true;
    estimated_ = seen_ > 0 && !probes_.starts.empty();
  }
  void forget() final { best_ = zero(at_); }
  std::optional<double> settled_error() final {
    if (seen_ > 0 || !estimated_) return {};
    estimated_ = false;
    return error_of(0, raw_[0], same_ ? ends_ : ends_of(best_));
  }
  void finish() final {
    move_to(0, 0);
    same_ = false;
  }

  /// Puts X = 0 on the resolution of the first scale.
  void begin(const std::vector<FlowScale>& scales) {
    at_ = seen_ = resolution_of_field(scales.front());
    now_ = best_ = zero(at_);
    blend_error_ = error_of(0, raw_[0], {});
    if (at_ == 0) return;
    place_probes(probes_);
    if (!probes_.starts.empty()) probes_.blend_error = probe({});
  }

  std::vector<MeshFlowLevel> take_levels() { return std::move(levels_); }

 protected:
  struct Pair {
    Signal source, target;
  };
  /// Where the source and the target are looked up for each unknown. Empty: at the unknown itself.
  struct Ends {
    std::vector<Place> source, target;
  };
  /// Places of the finest resolution at which errors of fields on coarser ones are taken.
  struct Probes {
    std::vector<Place> starts;
    Vector mass;
    double blend_error = 0;
  };

  explicit LevelAligner(const MeshFlowOptions& options) : options_(options) {}

  /// The coarsest resolution on which X of a level shows, and that on which its signals do: the same or a finer one.
  virtual int resolution_of_field(const FlowScale& scale) const = 0;
  virtual int resolution_of_signals(const FlowScale& scale) const { return resolution_of_field(scale); }
  virtual const Vector& masses(int m) const = 0;
  virtual Field zero(int m) const = 0;
  /// Ends of paths along X from every unknown, or from these places instead.
  virtual Ends ends_along(int m, const Field& X, const std::vector<Place>* starts) const = 0;
  virtual Signal looked_up(int m, const Signal& signal, const std::vector<Place>& places) const = 0;
  virtual void place_probes(Probes& probes) const = 0;
  /// X on the next finer resolution than m, complete or only as far as the next one needs it.
  virtual Field prolongated(int m, const Field& X) const = 0;
  virtual void complete(int, Field&) const {}
  virtual void advance(Field& X, double factor, const Field& Y) const = 0;
  virtual void keep_within_reach() {}
  /// ⟨X, S·X⟩ per area, X on the resolution at hand.
  virtual double smoothness_of(const Field& X) const = 0;

  /// Both fields on a finer resolution, and signals on this one.
  void move_to(int m, int of_signals) {
    for (Field* X : {&now_, &best_})
      if (m < at_) *X = carried(*X, m);
    at_ = m;
    seen_ = of_signals;
  }

  /// X, which is on the resolution at hand, on a finer one.
  Field carried(const Field& X, int to) const {
    Field result = prolongated(at_, X);
    for (int m = at_ - 1; m > to; --m) result = prolongated(m, result);
    complete(to, result);
    return result;
  }

  /// Of paths along X from every unknown of the signals.
  Ends ends_of(const Field& X) const {
    return seen_ < at_ ? ends_along(seen_, carried(X, seen_), nullptr) : ends_along(seen_, X, nullptr);
  }

  const Pair& signals() const { return signals_ ? *signals_ : raw_[std::size_t(seen_)]; }

  Pair warped(const Pair& pair, const Ends& ends) const {
    return {looked_up(seen_, pair.source, ends.source), looked_up(seen_, pair.target, ends.target)};
  }

  const MeshFlowOptions& options_;
  std::vector<Pair> raw_;  ///< prepared signals, per resolution

  int at_ = 0;         ///< the resolution at hand, of X
  int seen_ = 0;       ///< of signals
  Field now_, best_;   ///< X, and the one of the least error on the finest
  Ends ends_;          ///< of paths along X
  std::vector<MeshFlowLevel> levels_;
  double length_ = 0;  ///< ℓ of the level
  std::optional<Pair> signals_;  ///< at the level; none: as they are
  Pair met_;           ///< looked up along X, until a correction is made of it
  std::optional<BlockMultigrid> multigrid_;
  Field Y_;            ///< the correction at hand

 private:
  double error_of(int m, const Pair& pair, const Ends& ends) const {
    return mean_square_difference(masses(m), looked_up(m, pair.source, ends.source),
                                  looked_up(m, pair.target, ends.target));
  }

  /// The error at the probes.
  double probe(const Ends& ends) const {
    const auto at = [&](const Signal& signal, const std::vector<Place>& places) {
      return looked_up(0, signal, places.empty() ? probes_.starts : places);
    };
    return mean_square_difference(probes_.mass, at(raw_[0].source, ends.source), at(raw_[0].target, ends.target));
  }

  /// The error on the finest resolution of X on a coarser one: of the blend's, the share that is left at the probes.
  double error_from_coarse() const {
    const Field X = carried(now_, 0);
    if (probes_.starts.empty()) return error_of(0, raw_[0], ends_along(0, X, nullptr));
    const double left = probe(ends_along(0, X, &probes_.starts));
    return probes_.blend_error > 0 ? left / probes_.blend_error * blend_error_ : left;
  }

  double blend_error_ = 0;
  Probes probes_;
  bool same_ = true;        ///< X and the best one are the same, and `ends_` those of both
  bool followed_ = false;   ///< `ends_` are those of X already, at a level that begins
  bool estimated_ = false;  ///< the error of the best, at the probes
  double error_ = 0;        ///< of what was looked up
  double factor_ = 0;       ///< of the correction in X, while it is tried
  Ends next_ends_;          ///< then
  Pair next_;
  double next_error_ = 0;
};

}  // namespace mq
