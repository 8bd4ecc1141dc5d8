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

/// That for previews (material:binding:preview), wherever on the mesh's line it is; else that for all purposes; else
/// that for full renders. For one purpose it is that of the innermost prim, or of the outermost that says to be
/// stronger than descendants. Of one prim the first collection that has the mesh in it goes before what is bound
/// directly (UsdCollectionAPI: includes, excludes and expansionRule; not what includes other collections, nor
/// expressions). A material that is not there counts as bound, so that it is told; USD would look on.
UsdBinding usd_binding(const UsdText& text, const UsdMesh& mesh);

}  // namespace mq
