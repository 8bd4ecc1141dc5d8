#pragma once
/// How deep triangles lie on each other in a texture: trim sheets, or texture coordinates that nobody laid out.

#include "mq/atlas/atlas.h"
#include "mq/base/defect.h"
#include "mq/base/progress.h"

namespace mq {

struct OverlapDepth {
  double share = 0;  ///< of the texels in use, those that more than one triangle covers
  double mean = 0;   ///< triangles per texel in use
};

/// Counted at the centres of texels, as `texel_coverage` does; where triangles cover more than 2²² of them, each as
/// often as it is covered, at those of textures that are reduced until they do not.
OverlapDepth overlap_depth(const Surface& surface, const Atlas& atlas, const Progress& progress = {});

/// `deep_overlaps`, refused, where texels are covered by 64 triangles and more, the mean over whole textures, and by
/// 2²⁸ in all: each is cut and integrated by itself, which then takes minutes and gigabytes for a picture of which every
/// texel stands for that many places. Else nothing.
Defects deep_overlaps(const Surface& surface, const Atlas& atlas, const Progress& progress = {});

}  // namespace mq
