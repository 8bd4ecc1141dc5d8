#pragma once
/// Which triangle covers a place of a texture.

#include <span>
#include <vector>

#include "mq/atlas/atlas.h"

namespace mq {

/// Buckets of triangles over each texture, prepared once: a question looks at the few triangles of one
/// bucket. 4 bytes for each bucket that a triangle's box meets, a few per triangle.
class TrianglesAt {
 public:
  /// Triangles without chart are nowhere. Both must outlive the object.
  TrianglesAt(const Mesh& mesh, const Atlas& atlas);

  /// The first triangle that covers a place, its border included, of a texture as it is stored, and the
  /// weights of its corners there; −1 where there is none. Exact.
  struct Found {
    int triangle = -1;
    Vector3 barycentric = Vector3::Zero();
  };
  Found operator()(int texture, const TexelPoint& place) const;

 private:
  struct Buckets {
    int columns = 1, rows = 1;
    double left = 0, top = 0, side = 1;  ///< texels
    std::vector<int> first;              ///< per bucket, and one more
    std::vector<int> triangles;          ///< of each bucket increasing
  };

  const Atlas& atlas_;
  std::vector<Buckets> textures_;
};

}  // namespace mq
