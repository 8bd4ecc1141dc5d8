#include "mq/mesh/volume.h"

#include <Eigen/Geometry>

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {

double enclosed_volume(const Mesh& mesh) {
  const Box box = bounding_box(mesh);
  const Vector3 middle = 0.5 * (box.low + box.high);
  return parallel_sum(mesh.triangle_count(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (int t = int(begin); t < end; ++t) {
      const Vector3 q = mesh.position(t, 1) - middle, r = mesh.position(t, 2) - middle;
      sum += (mesh.position(t, 0) - middle).dot(q.cross(r));
    }
    return sum / 6;
  });
}

}  // namespace mq
