#pragma once
/// Laying charts out in the plane without a fold or an overlap.

#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/surface.h"

namespace mq {

struct FlattenOptions {
  int iterations = 60;      ///< at most, per chart
  double tolerance = 5e-4;  ///< stops where five in a row lower the energy by less each, relative
};

/// Charts in the plane, each in its own place at the scale of the surface (packing follows).
struct FlatCharts {
  std::vector<Vector2> uvs;  ///< model units
  std::vector<Triangle> corner_uvs;
  std::vector<int> charts;  ///< per triangle
  int count = 0;
};

/// Cuts the surface along `seams` (1 per half-edge of a seam) and flattens each part, which must be
/// a disc. From Tutte's embedding on a circle (How to draw a graph, 1963), which has no folds, the
/// symmetric Dirichlet energy Σ area (|J|² + |J⁻¹|²) is lowered by reweighted quadratic models
/// (Rabinovich, Poranne, Panozzo, Sorkine-Hornung, Scalable locally injective mappings, 2017); a
/// step that would turn a triangle over is shortened. Where the boundary crosses itself in the end,
/// the chart is done again with steps that never let it (Smith and Schaefer, Bijective
/// parameterization with free boundaries, 2015). So every chart is injective.
/// Throws `InvalidInput` when a part is no disc or a triangle has no area.
FlatCharts flatten(const Surface& surface, const std::vector<char>& seams,
                   const FlattenOptions& options = {}, const Progress& progress = {});

}  // namespace mq
