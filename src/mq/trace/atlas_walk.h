#pragma once
/// Straight on over the seams of an atlas: what lies beside a chart in the textures lies elsewhere on the surface.

#include <optional>
#include <vector>

#include "mq/atlas/atlas.h"

namespace mq {

/// A place of a texture in texels, as `Atlas::corners` count them, in a triangle that covers it.
struct AtlasPlace {
  int triangle = -1;
  Vector2 texel = Vector2::Zero();
};

/// Walks of a given way in texels. Within a chart the way is straight in its texture; across a seam it keeps its length
/// on the surface and its angle with the seam, as if both triangles lay in one plane, and goes on in the texels of the
/// other side.
class AtlasWalk {
 public:
  /// Both must outlive the object.
  AtlasWalk(const Surface& surface, const Atlas& atlas) : surface_(surface), atlas_(atlas) {}

  /// Where one arrives; nothing where the surface, or its part with a chart, ends on the way, or after 4096 triangles.
  /// Costs the triangles crossed.
  std::optional<AtlasPlace> operator()(const AtlasPlace& from, const Vector2& way) const;

 private:
  Vector2 corner(HalfEdge h) const;
  std::optional<HalfEdge> leave(int triangle, HalfEdge entry, Vector2& at, Vector2& way) const;
  void cross_seam(HalfEdge from, HalfEdge to, Vector2& at, Vector2& way) const;

  const Surface& surface_;
  const Atlas& atlas_;
};

}  // namespace mq
