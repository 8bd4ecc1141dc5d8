#pragma once
/// Sharpening and smoothing under a brush: the modulation changes at a few texels or vertices, and the
/// solution follows while one looks on.

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/solver.h"

namespace mq {

struct LiveOptions {
  /// How far around the changed unknowns `follow` solves, in lengths √w: outside, the solution falls
  /// off like exp(−distance/√w). What is sharpened changes from texel to texel, and falls off faster: at
  /// 2.5 no more than half a step of 8 bits is missing (`bench/live_bench`).
  double reach = 2.5;

  /// Per unknown, 0 to 1: what part of a modulation above 1 is that of texture (`HaloLimit::texture`), for which a
  /// second solution is kept up beside that for all of it, as `solve_without_halos` needs. Empty: one alone.
  std::vector<double> texture = {};
};

struct FollowOptions {
  double error = 0.5 / 255;  ///< the largest that may be left of a value, estimated: half a step of 8 bits
  int max_cycles = 8;
  /// `Followed::updates` from which on no further cycle begins, so that there is something to be seen soon: what is left
  /// over is followed up by `follow` again, or by the next change there.
  std::int64_t enough = std::numeric_limits<std::int64_t>::max();

  /// So many that one solve takes 10 to 20 milliseconds on two cores.
  static constexpr std::int64_t for_a_picture = 200'000;
};

/// What following a change took.
struct Followed {
  int cycles = 0;
  double error = 0;          ///< the largest that is left of a value near the change, estimated
  std::int64_t updates = 0;  ///< how often an unknown, or what stands for some on coarser levels, was relaxed
  std::int64_t unfinished = 0;  ///< unknowns around this and earlier changes where cycles ended with more error left
};

struct SettleOptions {
  double tolerance = 1e-6;  ///< relative to the right-hand side
  int max_cycles = 60;      ///< few, again and again: the solution can be looked at on its way
  int least_cycles = 0;     ///< more than a few tell the error, where the residual is small from the start
};

/// The solution of `ScreenedPoisson` for a modulation per unknown, a texel or a vertex,
///
///     (M + w·S)·(φ − ψ) = w·S_{β−1}·ψ,
///
/// kept up with changes of β. Right-hand side, residual and φ − ψ stay between changes: a change of β
/// costs the rows of the matrix it touches; following it, a few cycles of multigrid on the unknowns that
/// are near (`LocalMultigrid`), whose cost does not depend on how many others there are. What is too
/// small to be seen, what cycles that ended early leave over, and what that leaves for those further off, stays in
/// the residual and is solved for with the next change there, by `follow` again or by `settle`. Begins with β = 1,
/// which φ = ψ solves.
///
/// Thesis 5.9.1, which runs cycles over the whole atlas.
class LiveModulation {
 public:
  /// Assembles the system and makes its multigrid levels. ψ is size() × channels; `space` must outlive the object.
  /// Throws `InvalidInput` for a weight that is not positive and finite, or a signal or texture that does
  /// not fit or is not finite.
  LiveModulation(const TexelSpace& space, double weight, Signal psi, const LiveOptions& options = {},
                 const Progress& progress = {});
  LiveModulation(const VertexSpace& space, double weight, Signal psi, const LiveOptions& options = {},
                 const Progress& progress = {});
  ~LiveModulation();
  LiveModulation(LiveModulation&&) noexcept;

  /// Sets β at some unknowns, `beta[i]` at `unknowns[i]`. Throws `InvalidInput` naming the first that
  /// is none or not finite.
  void modulate(std::span<const int> unknowns, std::span<const double> beta);

  /// Solves around what was changed since the last time. If nothing was, once more where it did so last, and when
  /// nothing is unfinished there, everywhere that something is.
  Followed follow(const FollowOptions& options = {});

  /// The unknowns that the last `follow` may have changed, increasing.
  std::span<const int> followed() const;

  /// Solves everywhere. Stopped by `progress`, it leaves everything as it was.
  SolveReport settle(const SettleOptions& options = {}, const Progress& progress = {});

  /// β per unknown.
  std::span<const double> beta() const;

  /// b − A·(φ − ψ): what is left to be solved for, the channels as `signal` has them.
  const Signal& residual() const;

  /// φ now: the channels of ψ; with `LiveOptions::texture` followed by those of the solution for texture's part.
  const Signal& signal() const;

 private:
  struct System;
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace mq
