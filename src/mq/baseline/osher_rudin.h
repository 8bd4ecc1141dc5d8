#pragma once
/// Shock filters in their first form, on a fixed grid, to compare with.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/image_shock.h"
#include "mq/image/image.h"

namespace mq {

/// A signal evolved in explicit steps.
struct Evolved {
  std::vector<double> values;
  int steps = 0;
};

/// ∂φ/∂t = −|∇φ|·L(φ) (Osher and Rudin [osher1990feature]; with the first power of |∇φ|, as the
/// scheme of thesis 3.2.3 has it, not the second of its equation (3.1)), by upwind differences:
///
///     φ ← φ − ε·|m(d₋φ, d₊φ)|·d₋d₊φ,      ε ≤ 1 / (2 max |d₋d₊φ|),
///
/// m the value nearer to 0 of two of equal sign, else 0. Samples have distance 1; beyond the ends
/// the signal goes on constant. ε is the largest allowed, and what is left of `time` in the last
/// step. Keeps extrema, monotonicity and total variation. Stops early where nothing changes any
/// more.
Evolved osher_rudin(std::span<const double> signal, double time, int most_steps = 1'000'000);

struct OsherRudinOptions {
  enum class Scheme {
    bounded,    ///< no pixel passes the value of an extremum beside it, see below
    as_printed  ///< it may; and |L| counts at all pixels, also those that do not move
  } scheme = Scheme::bounded;
  double time = 1;
  Concavity concavity = Concavity::laplacian;
  int most_steps = 100'000;
  double least_change = 1e-6;  ///< it has come to rest where no value changed by more than this
                               ///< while the time doubled
};

/// An image evolved in explicit steps.
struct EvolvedImage {
  Image<float> image;
  int steps = 0;    ///< of the channel that took most
  double left = 0;  ///< of the time, where `most_steps` were too few
};

/// The same in two dimensions, each channel by itself: |∇φ| = (m(d₋ˣ, d₊ˣ)² + m(d₋ʸ, d₊ʸ)²)^½ and
/// ε ≤ 1 / (4 max |L|), pixels of side 1; the maximum is over the pixels that move, since at others
/// L is multiplied by 0. In a step an extremum keeps its value and every new value is between those
/// of the pixel and its four neighbours (m is no more than the way to a neighbour, so that it moves by √2/4 of the
/// way to the farthest at most); so values never leave their range. That alone lets a pixel beside an extremum, with
/// a steep slope at right angles, overtake it, after which it is none and drifts; so no pixel passes the value of an
/// extremum beside it. Extrema are those of the input: pixels of one value, joined
/// through their sides, with all others around them lower, or all higher. They keep their values
/// exactly and for ever, as the thesis says they do. Total variation and monotonicity are not kept.
///
/// Where the signal slopes small waves grow, the shorter the faster (for them the equation is that
/// of heat with time reversed): on wide edges rounding of 8 bits, and in the end of `float`,
/// becomes stripes of two to three pixels. That is the equation's, for any step.
EvolvedImage osher_rudin(const Image<float>& image, const OsherRudinOptions& options,
                         const Progress& progress = {});

/// What became of the extrema of an image (all channels), as they are defined above.
struct PassedExtrema {
  std::int64_t extrema = 0;  ///< of the image before
  std::int64_t passed = 0;   ///< of these, with a pixel beside them that is beyond the value they had
  double furthest = 0;       ///< by how much at most
};

PassedExtrema passed_extrema(const Image<float>& before, const Image<float>& after);

/// About how many steps that takes: of 48 × 48 pixels around the steepest place of each channel the
/// same is done for 2000 steps, and what is left of the time goes on in steps like the last.
double osher_rudin_steps(const Image<float>& image, const OsherRudinOptions& options);

/// The time for `osher_rudin`, whose speed is |∇φ|·L where that of paths is |∇φ|²·L: value if it is
/// absolute, and otherwise value·g/Λ with g² = ∫|∇φ|⁴/∫|∇φ|², the slope of edges, and Λ of the
/// potential, nothing smoothed.
double osher_rudin_time(const Image<float>& image, const ShockTime& time);

}  // namespace mq
