#pragma once
/// Sharpening and smoothing under a brush: the modulation changes at a few texels, and the solution
/// follows while one looks on.

#include <memory>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/solver.h"

namespace mq {

struct LiveOptions {
  /// ‖r‖ after `follow` over ‖r‖ before it. What is left is taken up by the next call.
  double tolerance = 0.1;
  /// How far around the changed texels `follow` solves, in lengths √w: outside, the solution falls
  /// off like exp(−distance/√w).
  double reach = 4;
};

struct SettleOptions {
  double tolerance = 1e-6;  ///< relative to the right-hand side
  int max_cycles = 60;      ///< few, again and again: the solution can be looked at on its way
};

/// The solution of `ScreenedPoisson` for a modulation per texel,
///
///     (M + w·S)·(φ − ψ) = w·S_{β−1}·ψ,
///
/// kept up with changes of β. Right-hand side, residual and φ − ψ stay between changes: a change of β
/// costs the rows of the matrix it touches; following it, a solve on the texels that are near, whose
/// multigrid levels stay until a change lies beyond them; what that leaves for the texels further off
/// stays in the residual and is solved for with the next change there, or by `settle`. Begins with
/// β = 1, which φ = ψ solves.
///
/// Thesis 5.9.1, which runs cycles over the whole atlas.
class LiveModulation {
 public:
  /// Assembles the system. ψ is size() × channels; `space` must outlive the object.
  /// Throws `InvalidInput` for a weight that is not positive and finite, or a signal that does not fit
  /// or is not finite.
  LiveModulation(const TexelSpace& space, double weight, Signal psi, const LiveOptions& options = {},
                 const Progress& progress = {});
  ~LiveModulation();
  LiveModulation(LiveModulation&&) noexcept;

  /// Sets β at some texels, `beta[i]` at unknown `texels[i]`. Throws `InvalidInput` naming the first
  /// that is no unknown or not finite.
  void modulate(std::span<const int> texels, std::span<const double> beta);

  /// Solves around what was changed since the last time, to the options' tolerance; once more where it
  /// did so last if nothing was.
  SolveReport follow();

  /// The texels that the last `follow` may have changed, increasing.
  std::span<const int> followed() const;

  /// Solves everywhere. The solver is kept for the next time with the same options. Stopped by
  /// `progress`, it leaves everything as it was.
  SolveReport settle(const SettleOptions& options = {}, const Progress& progress = {});

  /// β per unknown.
  std::span<const double> beta() const;

  /// φ now.
  const Signal& signal() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace mq
