#pragma once
/// Shock filters on a mesh: sharper edges, flat regions between them, and no value out of the range
/// there was.

#include <vector>

#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/trace/surface_flow.h"

namespace mq {

/// How much is smoothed before the potential is taken of the signal, and then the potential itself:
/// weights w = length² of `ScreenedPoisson`, model units squared. The thesis' α on the surface
/// scaled to unit area is w / area. 0: not at all.
struct ShockWeights {
  double signal = 0;
  double potential = 0;
};

/// P = ½ Σ_c |∇φ_c|² of all channels, constant on triangles; its mean over those around each
/// vertex, weighted by area; smoothed: thesis 3.3.1 (ComputeFlow), [prada2015shock]. φ is smoothed
/// before. One value per vertex, (unit of φ)²/length²; 0 at vertices that no area reaches. The two
/// solutions share a solver where the weights are equal; their reports are appended to `reports`
/// unless it is null. Throws `InvalidInput` on values that are not finite.
Vector shock_potential(const VertexSpace& space, const Signal& phi, const ShockWeights& weights,
                       const SolverFactory& factory = {},
                       std::vector<SolveReport>* reports = nullptr, const Progress& progress = {});

/// Λ = (∫ (ΔP)² dA / area)^½, with −ΔP = S·P over the lumped mass: the root mean square of the
/// Hessian of P on a flat surface without boundary (∫ (ΔP)² = ∫ |Hess P|²), and so of the rate at
/// which paths along ±∇P part or meet. Unit: that of P over length squared, which is 1/time. 0 for
/// a constant.
double potential_rate(const SignalSpace& space, const Vector& potential);

/// How long paths are followed.
struct ShockTime {
  enum class Unit {
    relative,  ///< τ: t = τ/Λ, whatever the size of the surface and of the values; 1 is mild, at 10
               ///< the narrowest edges have come to rest, those w times as wide at 10 w⁴
    absolute  ///< the thesis' own: on a surface scaled to area 1, on an image with pixels of side 1
  } unit = Unit::relative;
  double value = 1;  ///< not negative
};

/// In units of dp/dt = −∇P on the surface as it is: τ/Λ (0 where Λ is 0), or value · area².
double time_from(const ShockTime& time, const SignalSpace& space, const Vector& potential);
/// The same where Λ and the area are known.
double time_from(const ShockTime& time, double rate, double area);

/// A sharpened signal and how it came about.
struct Shocked {
  Signal signal;
  Vector potential;
  double rate = 0;  ///< Λ
  double time = 0;  ///< for which paths ran
  PathCounts counts;
  double path_seconds = 0;  ///< from the potential to the values looked up
  std::vector<SolveReport> solves;
};

/// ∂φ/∂t = −⟨∇P, ∇φ⟩ with the potential P of the signal at the start: φ_t = φ ∘ Ψ_t, where Ψ
/// follows −∇P (thesis 3.3.2 and 3.4.1, equations (3.6) and (3.7)). What is sampled is the signal
/// as it was given, unsmoothed; all channels at the same place.
///
/// Unconditionally stable: no value leaves the range of its channel, for any time. Minima of P keep
/// their values bit for bit, and so does a constant. Scaling φ by c and t by 1/c² changes nothing
/// but the scale. As t grows every vertex comes to have the value at a minimum of P.
///
/// The thesis writes F·∇φ with |∇φ|² in (3.1), where Osher and Rudin have |∇φ|: this is the former.
///
/// `signal` is size() × channels. Throws what `shock_potential` and `SurfaceFlow` throw.
Shocked transport_shock(const TraceMesh& mesh, const VertexSpace& space, const Signal& signal,
                        const ShockWeights& weights, const ShockTime& time,
                        const SolverFactory& factory = {},
                        const Progress& progress = {});

}  // namespace mq
