#pragma once
/// Evolving meshes that forget, to compare with: what an atlas that stays is worth.

#include "mq/evolving/evolving_mesh.h"

namespace mq {

enum class Forgetting {
  segments,  ///< all triangles are new wherever some are: a keyframe, as in [collet2015high]
  frames     ///< in every frame
};

/// The same surfaces with new ids for vertices and triangles, so that nothing lives longer, and no
/// chart of an atlas. Texture coordinates are left out.
EvolvingMesh with_new_ids(const EvolvingMesh& evolving, Forgetting forgetting);

}  // namespace mq
