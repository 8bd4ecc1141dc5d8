#pragma once
/// The screened Poisson equation in space and time (thesis 6.5.3, equation 6.2).

#include <functional>
#include <memory>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/fem/texels.h"
#include "mq/video/detail/time_links.h"
#include "mq/video/detail/time_multigrid.h"
#include "mq/video/frame_drift.h"

namespace mq {

/// How long other work on a frame takes, by the time of filtering it: for progress alone.
struct FrameCosts {
  double load = 0.4;
  double store = 0.1;
  std::vector<double> more = {};  ///< of loading single frames, beside `load`; empty: none

  /// Of loading frames from the first to the end.
  double loading(int first, int end) const;
};

struct TemporalOptions {
  double weight = 0;  ///< w of gradients in space, model units squared: alpha · area
  double beta = 1;    ///< what gradients in space are multiplied by
  double gamma = 1;   ///< γ of changes in time, frames squared
  double change = 0;  ///< what changes in time are multiplied by: 0 takes them out, 1 leaves them
  int window = 0;     ///< frames held at once; 0: twice the look-ahead and 8
  double accuracy = 0.01;  ///< what may be lost of a value beyond the look-ahead
  TimeMultigridOptions solver = {};
  FrameCosts costs = {};
};

/// A frame's signal: ψ, size() × channels.
struct TemporalFrame {
  std::shared_ptr<const SignalSpace> space;
  std::shared_ptr<const Texels> texels;  ///< of the space, for multigrid; none: planes are factored
  Signal psi;
  TimeLinks links;  ///< to the frame before; no rows in the first
  /// Where points slid to over the texels, of every frame or of none.
  std::shared_ptr<const FrameDrift> drift = {};
};

/// Gives a frame, and says how far it has come with it.
using FrameSource = std::function<TemporalFrame(int, const Progress&)>;

struct TemporalReport {
  SolveReport solve;   ///< of the window that took most cycles; seconds are those of all
  int windows = 0;     ///< that were solved one after another
  int held = 0;        ///< frames in the largest of them
  int look_ahead = 0;  ///< frames solved for beyond those that are kept
  double factor = 0;   ///< mean reduction of the residual per cycle, in the worst window

  void add(const SolveReport& window);
};

/// Of what a frame is changed by an unlimited past or future, the part that goes on to its
/// neighbour: r = (1 + 2γ − √(1 + 4γ)) / 2γ. Smooth signals are the worst: with a wave's λ, γ is γ
/// / (1 + wλ).
double decay_in_time(double gamma);

/// How far values in one frame reach into others, in frames: at most `accuracy` of them goes farther.
int look_ahead(const TemporalOptions& options);

/// How many of so many frames are held at once, at most.
int frames_held(int frames, const TemporalOptions& options);

/// Minimises, over the signals φ_f of all frames and for each channel alone,
///
///     E(φ) = Σ_f [ (φ_f − ψ_f)ᵀ m_f (φ_f − ψ_f) + w ∫ |∇φ_f − β∇ψ_f|² dA_f ]
///            + γ Σ_f (Dφ_f − η Dψ_f)ᵀ m̄_f (Dφ_f − η Dψ_f),
///
///     (Dφ_f)(t) = φ_f(t) − Σ_s w_ts φ_{f−1}(s)   along the links of frame f,
///
/// m_f the lumped mass, m̄_f the mean of m_f and m_{f−1} where a texel is linked to itself, else
/// m_f, η the `change`. So ν of (6.2) is η ∂ψ/∂t, and ∂/∂t is that of a point of the surface:
/// nothing flows where a point is added or removed. On one point of a surface that lasts (λ its
/// eigenvalue, ω radians a frame) the gain is
///
///     (1 + βwλ + η γ 2(1 − cos ω)) / (1 + wλ + γ 2(1 − cos ω)).
///
/// What of this borders decide is not left to so few terms, where charts change with γ > 0. The texels that show less
/// than half of what one beside them shows and are another texel in the frame before or after have that one's change
/// φ − ψ, in these terms too: squares over the few points where they meet the other frame would have them overshoot by
/// √γ times what frames differ by. And γ Σ min(m_t, m_u) (δ_t − δ_u)² over pairs beside each other, δ = φ − ψ, is added
/// where one of them begins in this frame or ends in it (β = 1 alone: else that would be in the way of gradients): what
/// time changes does not end in a step, but fades over about √γ texels.
///
/// Where frames have a `drift`, what ψ changes by as the surface slides under its texels is left as it is, and η is of the
/// rest: Dψ is ν + (Dψ − ν), ν the mean of ψ_{f−1}(p) − ψ_{f−1}(t), p where the point of texel t was, and of
/// ψ_f(t) − ψ_f(q), q where it went to of the frame before. So the change φ − ψ is that of light, and frames stay
/// sharp where surfaces are not tracked exactly.
///
/// w = 0 filters each texel alone; γ = 0 each frame, as `ScreenedPoisson` with a screen of ones
/// does (the same lumped mass). What is solved for is the change φ − ψ: where none is asked for ψ
/// comes back bit for bit.
///
/// Frames are asked for in their order, once each, and given back in their order; `window` of them
/// are held. A frame's space is let go when its matrix is made: it is given back where somebody
/// else has kept it, else there is none. Each window begins with the last value that was given back
/// and is solved to `look_ahead` frames beyond what is kept of it, so that of a value farther away
/// at most `accuracy` is missed. Memory is about 1 kB a texel and held frame, and 1.7 kB while a
/// window is set up (measured, see docs/relight.md).
///
/// Throws `InvalidInput` for weights that are negative or not finite, for a window that is no
/// longer than the look-ahead, and where links or signals do not fit their spaces.
TemporalReport temporal_poisson(int frames, const FrameSource& load,
                                const std::function<void(int, const TemporalFrame&, Signal)>& store,
                                const TemporalOptions& options = {}, const Progress& progress = {});

}  // namespace mq
