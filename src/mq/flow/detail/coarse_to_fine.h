#pragma once
/// The loop over levels that optical flow is on images and on surfaces: ScaleSpace with
/// IterativeFlowCorrection of thesis 4.3.3 [prada_thesis].

#include <optional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/flow/flow_options.h"

namespace mq {

/// A level's length ℓ, and whether its signals are smoothed by Smooth(φ, ½ℓ²), which is a Gaussian
/// of standard deviation ℓ, or left as they are.
struct FlowScale {
  double length = 0;
  enum class Signals { smoothed, unsmoothed } signals = Signals::smoothed;
  bool smoothed() const { return signals == Signals::smoothed; }
};

/// largest, largest/2, ..., as long as they are above `above`: so many at most.
std::vector<FlowScale> halved_scales(double largest, double above, int most = 40);

/// Errors of the level's signals of two fields, squared, over the places that both are seen at.
struct FlowErrorChange {
  double before = 0, after = 0;
};

/// A field X and a correction Y of it at hand.
class FlowCorrection {
 public:
  virtual ~FlowCorrection() = default;

  /// Tries X + factor·Y, which is then taken or left.
  virtual FlowErrorChange attempt(double factor) = 0;
  virtual void take() = 0;
  virtual void leave() = 0;
};

/// Takes X + factor·Y, factor = `scale`, 4 at most, or a half, a quarter, ... of it, `halvings` times, until the error
/// falls. Returns by how much; nothing where it never does.
std::optional<FlowErrorChange> take_what_gains(FlowCorrection& correction, double scale, int halvings,
                                               const Progress& progress);

/// What a domain knows: its signals, the field X at hand on the domain of the level, the best X so
/// far, and how X is corrected.
class FlowDomain : public FlowCorrection {
 public:
  virtual std::string name(const FlowScale& scale) const = 0;
  virtual double work(const FlowScale& scale) const = 0;  ///< that it takes, in any unit

  /// The error of X = 0, which is the linear blend's.
  virtual double blend_error() const = 0;

  /// Goes on to a level: signals smoothed, X and the best one on its domain. Returns what will be
  /// said of it, which stays until the next call.
  virtual FlowLevel& enter(const FlowScale& scale) = 0;

  /// Looks the signals up along X.
  virtual void look_up() = 0;

  /// At the level's signals: 0 where there is nothing to align.
  virtual double level_error() const = 0;

  virtual int most_steps() const = 0;

  /// Finds a correction Y; returns its α* of (4.8), 0 where there is nothing to correct. `share` is
  /// its part of `progress`.
  virtual double correct(const Progress& progress, double share) = 0;

  /// Ends the level: the error of X between the signals unsmoothed.
  virtual double measure() = 0;

  virtual void keep() = 0;    ///< X is the best
  virtual void forget() = 0;  ///< 0 is

  /// X becomes the best field where that has no larger error at this level's signals.
  /// `FlowPolicy::AfterWorse::better` only.
  virtual void go_back_if_better() {}

  /// The error of the best field, where it was an estimate until now.
  virtual std::optional<double> settled_error() { return {}; }

  /// The best field on the domain of the whole.
  virtual void finish() {}
};

/// What is not the same on all domains.
struct FlowPolicy {
  /// How often α* is halved before a correction is given up.
  int halvings = 2;

  /// Where a level goes on from after one that did not lower the error.
  enum class AfterWorse {
    last,   ///< its field, which may have been on the way to a large motion (images)
    better  ///< its field or the best, whichever has the lower error at its signals (surfaces)
  } after_worse = AfterWorse::last;

  double share = 1;  ///< of the progress
};

/// Per scale X is corrected up to `most_steps()` times, each time by α*Y as `step_length` says and
/// until one gains less than `least_gain`. Of all fields at the ends of levels the one of least
/// error is kept, with `FlowStepLength::scaled` the last. Returns the blend's error and that of the
/// field kept after each level, which never rises (but with `scaled`); where an estimate was settled
/// by one that is higher, earlier levels are not listed as lower.
std::vector<double> coarse_to_fine(FlowDomain& domain, const std::vector<FlowScale>& scales,
                                   const FlowOptions& options, const FlowPolicy& policy,
                                   const Progress& progress);

}  // namespace mq
