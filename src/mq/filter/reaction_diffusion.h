#pragma once
/// Patterns that grow by themselves: two substances that spread and react (Turing
/// [turing1952chemical]).

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Amounts of two substances per unknown, adjacent: u_0 v_0 u_1 v_1 ...
using Substances = std::vector<float>;

/// What a reaction makes of a run of unknowns per unit of time: rate[k] for state[k], both laid out
/// as `Substances`. Called for runs of at most 1024 unknowns, from several threads.
using Reaction = std::function<void(std::span<const float> state, std::span<float> rate)>;

/// ∂u/∂t = −u v² + F (1 − u), ∂v/∂t = u v² − (F + k) v (Gray and Scott [gray1984autocatalytic];
/// Pearson [pearson1993complex]).
struct GrayScott {
  double feed = 0.035;  ///< F
  double kill = 0.065;  ///< k
};
Reaction gray_scott(const GrayScott& rates);

/// A named pattern of Gray and Scott's reaction where v spreads half as fast as u.
struct GrayScottPreset {
  std::string name;
  GrayScott rates;
  /// 2π √(∫ v² / ∫ |∇v|²) of the pattern, v taken from its mean, where D_u = 0.16 lengths² per unit
  /// of time, in these lengths. Measured on 128² of them at two texels each after 10000 units of
  /// time.
  double wave_length;
};
const std::vector<GrayScottPreset>& gray_scott_presets();

/// D_u and D_v for which a preset has waves of this length.
std::array<double, 2> diffusivities(const GrayScottPreset& preset, double wave_length);

/// ∂w/∂t = D Δw + R(w) on a signal space, by explicit steps
///
///     w_i ← w_i + τ (R(w)_i − D/m_i Σ_j S_ij (w_j − w_i)),
///
/// M lumped. A step is stable up to τ D Σ_j |S_ij| / m_i = ¾; where texels are smaller than that
/// allows (at seams, in stretched charts) their m_i is taken as large as it asks for: they change
/// more slowly. A constant with R = 0 stays, bit for bit. Single precision; the same bits for any
/// number of threads.
class ReactionDiffusion {
 public:
  /// Steps of length τ ≤ `longest_step`, as long as all but a tenth of the unknowns allow. Throws
  /// `InvalidInput` where diffusivities are negative or a length is not positive.
  ReactionDiffusion(const SignalSpace& space, std::array<double, 2> diffusivity,
                    double longest_step = 1, const Progress& progress = {});

  /// Advances by `steps`. Cost: a pass over S in single precision each.
  void run(const Reaction& reaction, int steps, Substances& state,
           const Progress& progress = {}) const;

  int size() const { return int(begin_.size()) - 1; }
  double time_step() const { return step_; }
  double slowed() const { return slowed_; }  ///< share of the unknowns with m_i raised
  std::int64_t bytes_per_step() const;       ///< read and written once

 private:
  void advance(const Reaction& reaction, const Substances& from, Substances& to) const;

  std::vector<int> begin_, column_;
  std::vector<float> weight_;  ///< −τ S_ij / m_i
  std::array<float, 2> diffusivity_;
  double step_ = 1;
  double slowed_ = 0;
};

/// u = 1, v = 0, and spots of u = ½, v = ¼ about `spacing` apart, at places that depend on the
/// seed; a fiftieth of the places at least.
Substances seeded_substances(std::span<const Vector3> places, double spacing, std::uint64_t seed);

}  // namespace mq
