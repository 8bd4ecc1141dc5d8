#pragma once
/// Coarse levels that know no charts: points on a surface and the graph of a matrix.

#include <array>
#include <memory>
#include <vector>

#include "mq/linear/matrix.h"
#include "mq/linear/transfer.h"

namespace mq {

/// Points in space whose coupling a matrix gives.
struct SurfacePoints {
  std::vector<std::array<float, 3>> positions;
  std::vector<float> spacing;  ///< how close neighbours are, in the direction where they are closest
  /// Where levels are to stay as close as this one: 1 per point whose spacing does not grow. Empty: none.
  std::vector<char> kept;
};

/// The same points in a unit, a power of two, in which the largest spacing is 1 to 2: the fourth power of a distance
/// between coarse points then stays in single precision, whatever the model's unit is. No other bit changes.
SurfacePoints in_own_unit(SurfacePoints points);

struct GraphCoarsening {
  std::unique_ptr<SparseTransfer> transfer;
  SurfacePoints coarse;
};

/// Chooses points so that each point has one within `radius` of its spacings along edges of the
/// graph of A, and writes every point as a combination of at most three of them: of the corners of a
/// triangle of mutually adjacent chosen points whose projection holds it, else of the ends of the
/// nearest edge. Where points are closer in one direction than in another, fewer are left in that
/// direction only. A component of the graph keeps at least one point. Weights are in [0, 1]. Kept points
/// stop being kept where they are more than a tenth of those chosen.
///
/// Wiersma, Nasikun, Eisemann and Hildebrandt 2023, with a spacing of its own for every point.
GraphCoarsening coarsen_graph(const SparseMatrix& A, const SurfacePoints& points, double radius);

}  // namespace mq
