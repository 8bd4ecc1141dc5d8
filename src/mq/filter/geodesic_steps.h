#pragma once
/// The steps of the heat method, for `GeodesicDistance`, for `LiveGeodesic`, and for one of several processes that has
/// some of the unknowns (shared_unknowns.h). Then sources are its own, and spaces and matrices have complete rows of
/// its own unknowns.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/filter/geodesic.h"
#include "mq/filter/shared_unknowns.h"

namespace mq {

/// What the spread of heat knows of a space.
struct GeodesicDomain {
  double length;             ///< √t
  double spacing;            ///< mean, of neighbouring unknowns
  const SparseMatrix& heat;  ///< M + t·S, M lumped
  std::span<const Vector3> positions;
  std::span<const int> boundary;
};

/// Mean distance of neighbouring unknowns; that of equilateral triangles where there is no grid.
double mean_spacing(const SignalSpace& space);

/// What `GeodesicOptions::time` counts, squared: h̄², the mean spacing's, or where texels are stretched that of the longer
/// side divided by 2. `S` is the stiffness, `mass` M lumped.
///
/// A texel of sides a ≥ b has S_ii = 4/3·(e + 1/e), e = a/b, and a² = e·h̄²: the factor is e/2 for what a tenth of the
/// area exceeds, to a tenth, and at least 1. In shears and in metrics of other kinds e is that of the metric's axes.
/// Heat has to get across a texel, however narrow the next one is: with √t a third of the longer side distances are a
/// quarter off.
double heat_spacing(double spacing, const SparseMatrix& S, const Vector& mass,
                    const SharedUnknowns& shared = SharedUnknowns::alone());

/// The same of a whole space; the mean spacing where there is no grid.
double heat_spacing(const SignalSpace& space, const SparseMatrix& S, const Vector& mass);

/// S becomes M + t·S with M lumped.
void make_heat_matrix(const Vector& mass, double t, SparseMatrix& S);

/// Throws `InvalidInput` where there are none, or one is no unknown or its distance negative or not finite.
void require_sources(const std::vector<GeodesicSource>& sources, int size);

/// How many spacings around a source that is a point have their straight distances from it.
inline constexpr double disc_spacings = 3;

/// How far the disc around a source at this unknown reaches, model units.
double disc_radius(const SparseMatrix& A, std::span<const Vector3> positions, double spacing, int unknown,
                   double radius = disc_spacings);

/// Sources with those around their points, each unknown once at the least of its distances. Within `radius`
/// spacings, where all of these lie near a plane.
std::vector<GeodesicSource> grown_sources(const SparseMatrix& A, std::span<const Vector3> positions,
                                          double spacing, const std::vector<GeodesicSource>& sources,
                                          double radius = disc_spacings);

/// |∇w| per element, at least what there is a direction from.
std::vector<float> gradient_lengths(const SignalSpace& space, const Signal& w);

/// w brought to slope 1 and continued near boundaries, but for sources, from what lies farther
/// inside. `first` are the distances that sweeps began with, infinite where no source leads to: w
/// stays as it is there.
void continue_to_boundary(const GeodesicDomain& domain, const std::vector<GeodesicSource>& sources,
                          const Vector& first, Signal& w, const Progress& progress,
                          const SharedUnknowns& shared = SharedUnknowns::alone());

/// A first guess of distances that has their directions, and how the heat spread.
struct HeatDistances {
  Signal w;  ///< −√t·log u, continued to boundaries
  int sweeps = 0;
  double change = 0;
};

/// `sources` are grown.
HeatDistances heat_distances(const GeodesicDomain& domain, const std::vector<GeodesicSource>& sources,
                             const GeodesicOptions& options, const Progress& progress,
                             const SharedUnknowns& shared = SharedUnknowns::alone());

/// ∫ ⟨∇w/|∇w|, ∇φ_i⟩ dA.
Signal unit_gradient_moments(const SignalSpace& space, const Signal& w);

/// Shifts each component such that the given distances are met on average, and then takes these; infinite
/// where a component has none. Returns how many unknowns are infinite.
int meet_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component,
                 Vector& distance);

/// The same in two steps, between which processes add up: per component, numbered from 0 to before `components`, by how
/// much distances miss the given ones in all, and at how many sources.
Signal missed_at_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component, int components,
                         const Vector& distance);
int meet_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component, const Signal& missed,
                 Vector& distance);

}  // namespace mq
