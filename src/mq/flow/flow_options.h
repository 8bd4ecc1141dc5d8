#pragma once
/// What optical flow is asked, and what it says of its levels, alike on images and on surfaces. Each
/// kind has its own defaults: `ImageFlowOptions`, `MeshFlowOptions`.

#include "mq/base/length.h"

namespace mq {

/// What a signal is aligned to (table 4.1 of the thesis).
enum class FlowAlignment {
  halfway,  ///< φ₀(p − X/2) ≈ φ₁(p + X/2): neither is preferred; swapped signals give −X
  forward   ///< φ₀(p) ≈ φ₁(p + X)
};

/// How far a correction Y is followed.
enum class FlowStepLength {
  falling_error,  ///< α*, 4 at most, or by a half, a quarter, ... of it until the level's error falls
  scaled          ///< α* of (4.8), whatever becomes of the error
};

/// Levels go from large to small lengths ℓ: signals are smoothed and fields are smooth over about ℓ,
/// which is halved from one to the next. For the last one signals are as they are.
struct FlowOptions {
  FlowAlignment alignment = FlowAlignment::halfway;

  /// Changes slower than this are taken as light and left out: φ − Smooth(φ, length²). 0: nothing
  /// is.
  Length detail{};

  Length largest{};   ///< ℓ of the first level: about half of the longest motion
  Length smallest{};  ///< ℓ of the last

  int steps = 1;           ///< corrections at a level, at most ...
  double least_gain = 0;   ///< ... and until one takes off less than this share of the squared error
  FlowStepLength step_length = FlowStepLength::falling_error;

  /// ϵ of ψ(s²) = 2ϵ²(√(1 + s²/ϵ²) − 1), in place of s²: s² where s is small and 2ϵ|s| where it is
  /// large; for differences (in standard deviations of the signals) and for |∇Y| (a number). 0:
  /// squares. Solved by reweighting, so often.
  double robust_data = 0;
  double robust_smoothness = 0;
  int reweightings = 3;

  /// Weight of the signals' slopes beside the signals themselves, which light that changes slowly
  /// leaves as they are (after Brox, Bruhn, Papenberg, Weickert, High accuracy optical flow
  /// estimation based on a theory for warping, 2004). On images of both components, brought to the
  /// mean square of the signals; on surfaces, where only the length can be compared, of ℓ·|∇φ|. 0:
  /// none.
  double gradient_weight = 0;

  double tolerance = 1e-3;  ///< relative residual of the linear systems, where they are iterated
};

/// What each level says.
struct FlowLevel {
  double length = 0;   ///< ℓ, pixels or model units
  int steps = 0;       ///< corrections taken
  int cycles = 0;      ///< of the linear solver, all corrections
  double error = 0;    ///< of the best field so far, as the flow has it
  double seconds = 0;  ///< of the level, with measuring its error
};

}  // namespace mq
