#include "mq/draw/corner_normals.h"

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {

std::vector<Eigen::Vector3f> corner_normals(const Mesh& mesh) {
  const std::vector<Vector3> vertices = vertex_normals(mesh);
  constexpr double crease = 0.7660444431;  // cos 40°
  std::vector<Eigen::Vector3f> normals(std::size_t(mesh.triangle_count()) * 3);
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    const Vector3 face = triangle_normal(mesh, int(t));
    for (int k = 0; k < 3; ++k) {
      const Vector3& smooth = vertices[mesh.triangles[t][k]];
      normals[3 * t + k] = (smooth.dot(face) > crease ? smooth : face).cast<float>();
    }
  });
  return normals;
}

}  // namespace mq
