#pragma once
/// Which material a mesh of USD is bound to (UsdShadeMaterialBindingAPI).

#include <string>
#include <vector>

#include "mq/io/detail/usd_mesh.h"

namespace mq {

struct UsdBinding {
  std::string material;            ///< its path from the root; empty: none is bound
  std::vector<std::string> notes;  ///< what of bindings is not followed
};

/// For previews or for all purposes: that of the innermost prim of the mesh's line, or of the
/// outermost that says to be stronger. Of one prim the first collection that has the mesh in it
/// goes before what is bound directly (UsdCollectionAPI: includes, excludes and expansionRule; not
/// what includes other collections, nor expressions).
UsdBinding usd_binding(const UsdText& text, const UsdMesh& mesh);

}  // namespace mq
