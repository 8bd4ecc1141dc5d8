#pragma once
/// How badly one surface is shown by another, vertex by vertex: what local remeshing starts from.

#include <array>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/surface.h"

namespace mq {

struct MismatchOptions {
  double tolerance = 0;     ///< distance of score 1 on open, flat surface, model units, above 0
  double occlusion = 0.75;  ///< 0 to 1: how much less counts what cannot be seen
  double curvature = 2;     ///< from 0: how much more counts what is bent
  double least = 0.5;       ///< scores that cannot reach it are not modulated
  double farthest = 0;      ///< distance of score 1 at least, wherever it is; 0: none is
  /// Nearest points of the other surface, where they are known; empty: they are looked for.
  std::span<const ClosestPoint> places = {};
};

/// Per vertex of a surface how it is shown by the other one.
struct Mismatch {
  std::vector<ClosestPoint> places;  ///< nearest point of the other surface
  std::vector<double> scores;        ///< above 1: the other surface does not show it
};

/// The score of a vertex v (thesis 6.3.2, which names its parts but no formula)
///
///     s(v) = d(v) / tolerance · (1 − o + o·V(v)) · (1 + c·min(1, κ(v)·h)),
///
/// d the distance to the other surface, V the share of directions, weighted by the cosine to the
/// normal, in which nothing of the surface itself is in the way (1 minus its ambient occlusion), κ
/// the larger of the absolute principal curvatures, h the surface's mean edge, o and c the options'
/// `occlusion` and `curvature`; d / `farthest` where that is more. Without a unit. V is found only
/// where d and κ alone reach `least`, and κ only where d does with the most that κ can add; elsewhere
/// they count as 1 and 0. A vertex that no triangle uses has score 0.
Mismatch mismatch(const Surface& surface, const ClosestPointFinder& other,
                  const MismatchOptions& options, const Progress& progress = {});

/// V of the formula above at some of a surface's vertices, by 64 rays each; 1 where there is no
/// normal. A closed surface of negative volume is seen from the
/// other side.
std::vector<double> visibility(const Surface& surface, std::span<const int> vertices,
                               const Progress& progress = {});

/// Per triangle 1 where its shape differs too much from its rest shape: where the
/// singular values of the linear map between them differ by a factor above 3, or areas by one above
/// 3 either way. `rest` has its corners then. Throws `InvalidInput` unless there are as many as
/// triangles.
std::vector<char> distorted_triangles(const Mesh& mesh,
                                      std::span<const std::array<Vector3, 3>> rest);

}  // namespace mq
