#pragma once
/// A pattern of reaction and diffusion from its seeds to its end, in as few unknowns as its waves need.

#include <functional>
#include <memory>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/evenly_spaced_surface.h"
#include "mq/filter/reaction_diffusion.h"

namespace mq {

/// An explicit step of time may be as long as the square of the spacing, so that a wave of n texels takes n⁴ of
/// something on a surface, and the smallest texels decide. But a pattern with waves of `vertices_per_wave` vertices grows
/// as one with more, and stays where it is when it is looked at more finely. So it grows on an evenly spaced surface,
/// and the unknowns of the space, texels or vertices, take their values from there. Where these lie closer than
/// half its spacing, the last of the time passes on one of twice as many vertices a wave, so that triangles are not seen.
/// Where a wave has hardly `least_texels` unknowns, or there is no surface to take, all of it takes place on the space.
class PatternGrowth {
 public:
  /// With 12 the decay of a wave is taken for 2 % faster than it is, (2π/12)²/12; with 8 spots get longish, as vertices do not
  /// lie evenly enough.
  static constexpr double vertices_per_wave = 12;
  static constexpr double least_texels = 6;

  /// Time on the finer surface at the end: in a few units a pattern's own spreading levels what is as fine as the one before.
  static constexpr double last_time = 16;

  /// `wave_length` in model units. `surface`: that of the space, whose metric it has; null where there is none with that
  /// metric. `components`: per unknown that of the surface (`triangle_components`), none where it does not matter as no
  /// two lie on each other. The space must outlive it. Throws what `ReactionDiffusion` and `EvenlySpacedSurface` throw.
  PatternGrowth(const SignalSpace& space, const Surface* surface, std::vector<int> components,
                std::array<double, 2> diffusivity, double wave_length, double time, const Progress& progress = {});

  /// A run on an evenly spaced surface, or on the space.
  struct Stage {
    const ReactionDiffusion* process;
    double steps;  ///< a whole number, however large
  };
  /// One or two.
  std::vector<Stage> stages() const;

  /// `seeded_substances` where it begins.
  Substances seeds(std::uint64_t seed) const;

  /// Told, after the first few steps, how many seconds the others will take.
  using Expect = std::function<void(double seconds)>;

  /// What becomes of `seeds`, per unknown of the space. Throws `InvalidInput` for more than 2³¹ steps.
  Substances grow(const Reaction& reaction, Substances seeds, const Expect& expect = {},
                  const Progress& progress = {}) const;

 private:
  /// Where it grows for a time; no surface: on the space.
  struct Place {
    std::unique_ptr<EvenlySpacedSurface> surface;
    std::unique_ptr<ReactionDiffusion> process;
    double time;
  };
  const SignalSpace& at(const Place& place) const;

  const SignalSpace& space_;
  std::vector<int> components_;
  double wave_length_;
  std::vector<Place> places_;
};

}  // namespace mq
