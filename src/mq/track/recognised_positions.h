#pragma once
/// Where a surface may be on one that is too far from it for closest points: its limbs have swung by their
/// length, and what is nearest to one of them is another (after Zhang and others [zhang2008deformation]:
/// extremities are matched in several ways, each of which is tried).

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/track/deformation_graph.h"
#include "mq/track/tracking.h"

namespace mq {

struct RecognitionOptions {
  double spacing = 0;     ///< of the graph's nodes
  double elasticity = 0;  ///< see `TrackOptions`
};

/// Positions of a surface near to a target, at most two, the nearer ones first; none where too few
/// extremities are alike. The graph carries it there from `current`; `rest` is the surface as it was made;
/// its extremities are looked for where `begin` has them.
///
/// Extremities of both are matched by how far they are apart along the surfaces (`matched_extremities`).
/// A vertex x is then looked for at the point y of the target where
///
///     p·|y − x|² + n·(1 − cosine of the normals) + mean over extremities of min(difference of lengths, 4)²
///
/// is least, in spacings, p and n small at first. These points pull the graph while it becomes less stiff,
/// those that are less alike the less (Welsch): lengths differ where surfaces touch that did not.
std::vector<std::vector<Vector3>> recognised_positions(DeformationGraph& graph, const Mesh& rest,
                                                       std::span<const Vector3> current,
                                                       std::span<const Vector3> begin,
                                                       const TrackTarget& target,
                                                       const RecognitionOptions& options,
                                                       const Progress& progress = {});

}  // namespace mq
