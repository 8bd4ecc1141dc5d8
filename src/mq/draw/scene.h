#pragma once
/// The triangles of a mesh, asked which of them a line of sight meets first.

#include <memory>

#include "mq/draw/camera.h"
#include "mq/mesh/surface.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// Where a ray meets a mesh; triangle -1: it meets none.
struct Hit : SurfacePoint {
  Vector3 point = Vector3::Zero();
};

/// Built once per surface, which must outlive it; asked from any number of threads. Embree finds a
/// triangle in single precision; which of its neighbours the ray meets, and where, is then decided
/// in double, so that answers do not depend on how the hierarchy was built.
class Scene {
 public:
  /// Degenerate triangles are never met. Throws `Unsupported` when Embree does not start.
  explicit Scene(const Surface& surface);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  Hit hit(const Ray& ray) const;

 private:
  struct Hierarchy;
  const Surface& surface_;
  std::unique_ptr<Hierarchy> hierarchy_;
};

}  // namespace mq
