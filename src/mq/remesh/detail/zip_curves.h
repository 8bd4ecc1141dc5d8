#pragma once
/// Closing the gap between two surfaces along a pair of curves with a strip of triangles.

#include <span>
#include <vector>

#include "mq/remesh/detail/clip_surfaces.h"

namespace mq {

/// Which curve of the template goes with which of the target.
struct CurvePairs {
  std::vector<std::array<int, 2>> pairs;  ///< indices into the curves: template, target
  std::vector<int> alone;                 ///< curves without a partner, of either
};

/// Two curves are partners when most vertices of each lie nearest to the other, among the curves of
/// the other surface, where normals agree, within `reach` (model units), and both are closed or
/// both open.
CurvePairs pair_curves(const SurfacePair& pair, const std::vector<CutCurve>& curves, double reach);

/// A strip between two curves.
struct Strip {
  std::vector<Triangle> triangles;
  double cost = 0;  ///< sum of squared lengths of the edges across, and what bent ones cost more
};

/// Whether a triangle in the pair's vertices is flipped: by 80 degrees or more against the sum
/// of the normals of its corners or 100 against one of them; or has a height of less than a
/// thousandth of its longest edge.
bool is_bad(const SurfacePair& pair, const Triangle& triangle);

/// The strip of triangles between a curve of the template and its partner that costs least, where
/// each triangle has an edge on one of them: found by dynamic programming over both arc lengths. It
/// begins where the curves are nearest to each other; open curves begin and end together. The sum
/// is of |a − b|² (1 + 4 (1 − cos δ)) over triangles, ab the edge where one ends and δ the angle
/// between its normal and those of its corners; a bad triangle is avoided at any cost. O(n·m) for
/// curves of n and m edges, and for long ones only near the diagonal. Throws `InvalidInput` for
/// closed curves of less than three edges.
Strip zip(const SurfacePair& pair, const CutCurve& of_template, const CutCurve& of_target);

}  // namespace mq
