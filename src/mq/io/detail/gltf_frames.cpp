// Through a node's matrix M normals go as M⁻ᵀ n, tangents as M t. A mirroring M turns N × T the other
// way than M (N × T), so w changes its sign with det M.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// The values of an accessor that has one for each vertex; none without.
GltfValues values_for(const GltfFile& file, std::int64_t accessor, int components,
                      const GltfTriangles& part) {
  if (accessor < 0) return {};
  GltfValues values = file.values(accessor, {components});
  if (int(values.count()) != part.vertex_count)
    GltfFile::fail(file.place("accessors", accessor),
                   fmt::format("{} normals or tangents for {} vertices", values.count(),
                               part.vertex_count));
  return values;
}

void read_part(const GltfFile& file, const Mesh& mesh, const GltfTriangles& part, std::size_t end,
               GltfTangents wanted, CornerFrames& frames) {
  const GltfValues normals = values_for(file, part.normals, 3, part);
  const bool reads = wanted == GltfTangents::read && part.normals >= 0;
  const GltfValues tangents = values_for(file, reads ? part.tangents : -1, 4, part);
  const Eigen::Matrix3d matrix = part.matrix.topLeftCorner<3, 3>();
  // The matrix of cofactors: M⁻ᵀ det M, also where det M is 0.
  Eigen::Matrix3d cofactors;
  for (int k = 0; k < 3; ++k)
    cofactors.col(k) = matrix.col((k + 1) % 3).cross(matrix.col((k + 2) % 3));
  const double turn = matrix.determinant() < 0 ? -1 : 1;
  for (std::size_t t = part.begin; t < end; ++t)
    for (int k = 0; k < 3; ++k) {
      const std::size_t corner = 3 * t + std::size_t(k);
      const std::size_t i = std::size_t(mesh.triangles[t][k] - part.vertices);
      if (part.normals < 0) {
        frames.normals[corner] = triangle_normal(mesh, int(t)).cast<float>();
      } else {
        const Vector3 n = turn * (cofactors * Vector3::Map(&normals.values[3 * i]));
        frames.normals[corner] = n.normalized().cast<float>();
      }
      if (tangents.values.empty()) continue;
      const Vector3 along = matrix * Vector3::Map(&tangents.values[4 * i]);
      frames.tangents[corner] << along.normalized().cast<float>(),
          float(turn * (tangents.values[4 * i + 3] < 0 ? -1 : 1));
    }
}

}  // namespace

CornerFrames gltf_frames(const GltfFile& file, const GltfScene& scene, GltfTangents tangents) {
  const Mesh& mesh = scene.file.mesh;
  const std::size_t count = mesh.triangles.size();
  CornerFrames frames{std::vector<Eigen::Vector3f>(3 * count, Eigen::Vector3f::Zero()),
                      std::vector<Eigen::Vector4f>(3 * count, Eigen::Vector4f::Zero())};
  for (std::size_t p = 0; p < scene.triangles.size(); ++p) {
    const std::size_t end = p + 1 < scene.triangles.size() ? scene.triangles[p + 1].begin : count;
    read_part(file, mesh, scene.triangles[p], end, tangents, frames);
  }
  return frames;
}

}  // namespace mq
