#pragma once
/// What filters in time do to the textures of a sequence: how much less these flicker, how much of
/// their gradients is left, and how near they come to what they should be.

#include <optional>
#include <vector>

#include "mq/video/flicker.h"
#include "mq/video/temporal_poisson.h"

namespace mq {

/// How near signals φ are to true ones τ, up to one factor c for all of them.
struct TruthComparison {
  double factor = 1;  ///< c = Σ⟨φ, τ⟩ / Σ⟨φ, φ⟩
  double error = 0;   ///< √ mean |c·φ − τ|², over the values that count
  /// √(½ mean |Δ(c·φ − τ)|²), Δ from one frame to the next of a texel that is the same in both: flicker alone, as what
  /// slides under texels does so in both.
  double flicker = 0;
  double sharpness =
      0;  ///< Σ⟨φ, τ⟩ / Σ⟨τ, τ⟩ in the inner product of gradients: 1, nothing is lost
};

struct RelightMeasures {
  struct Side {
    Flicker flicker;
    std::optional<TruthComparison> truth;  ///< where one was given
  };
  Side before, after;
  double gradients = 1;  ///< √(Σ|∇ after|² / Σ|∇ before|²)
};

/// Takes frames in their order.
class RelightMeter {
 public:
  /// Of a frame with links and texels, as they are filtered, what its signal was and is; `truth`
  /// may be null, for all frames or for none. `drift`: what was found in the frames as they were.
  void add(const TemporalFrame& frame, const SignalSpace& space, const Signal& was,
           const Signal& is, const Signal* truth, const FrameDrift* drift = nullptr);

  RelightMeasures finish();

 private:
  /// Sums over frames.
  struct Sums {
    FlickerMeter flicker;
    double gradients = 0;
    bool compared = false;
    double products = 0, squares = 0, truths = 0, values = 0;
    double mixed_gradients = 0, true_gradients = 0;
    double steps = 0, mixed_steps = 0, true_steps = 0, step_count = 0;
    Signal last, last_truth;
    std::vector<char> last_counted;

    void add(const TemporalFrame& frame, const SignalSpace& space, const Signal& signal,
             const Signal* truth, const FrameDrift* drift);
    void compare(const TemporalFrame& frame, const SignalSpace& space, const Signal& signal, const Signal& truth);
    void compare_steps(const TemporalFrame& frame, const Signal& signal, const Signal& truth);
    RelightMeasures::Side finish();
  };

  Sums before_, after_;
};

}  // namespace mq
