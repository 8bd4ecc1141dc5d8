#pragma once
/// The parts of the heat method that `GeodesicDistance` and `LiveGeodesic` share. Used inside this room.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/filter/geodesic.h"

namespace mq {

/// What the method knows of a space.
struct GeodesicDomain {
  const SignalSpace& space;
  double length;             ///< √t
  const SparseMatrix& heat;  ///< M + t·S, M lumped
  std::span<const Vector3> positions;
  std::span<const int> boundary;
};

/// Mean distance of neighbouring unknowns; that of equilateral triangles where there is no grid.
double mean_spacing(const SignalSpace& space);

/// M + t·S with M lumped.
SparseMatrix heat_matrix(const SignalSpace& space, double t, const Progress& progress);

/// Throws `InvalidInput` where there are none, or one is no unknown or its distance negative or not finite.
void require_sources(const std::vector<GeodesicSource>& sources, int size);

/// How many spacings around a source that is a point have their straight distances from it.
inline constexpr double disc_spacings = 3;

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
                          const Vector& first, Signal& w, const Progress& progress);

/// Shifts each component such that the given distances are met on average, and then takes these; infinite
/// where a component has none. Returns how many unknowns are infinite.
int meet_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component,
                 Vector& distance);

}  // namespace mq
