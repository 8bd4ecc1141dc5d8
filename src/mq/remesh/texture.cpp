#include "mq/remesh/texture.h"

#include <algorithm>

#include "mq/base/error.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

/// Takes texture coordinates of one surface over to the mesh.
class Atlas {
 public:
  Atlas(const Mesh& from, int first_texture, Mesh& to)
      : from_(from), to_(to), first_uv_(int(to.uvs.size())), first_texture_(first_texture) {
    to.uvs.insert(to.uvs.end(), from.uvs.begin(), from.uvs.end());
  }

  /// Of triangle t, which is triangle `source` here.
  void take_over(int t, int source) {
    require(source < from_.triangle_count(), "the remeshed surface is not made of these two");
    if (!from_.textured(source)) return;
    for (int k = 0; k < 3; ++k) to_.corner_uvs[t][k] = first_uv_ + from_.corner_uvs[source][k];
    to_.textures[t] = texture(source);
  }

  /// Of triangle t, which shows what the triangle `nearest` to it here shows.
  void look_up(int t, int nearest) {
    if (!from_.textured(nearest)) return;
    for (int k = 0; k < 3; ++k) {
      const Vector3 b = closest_point(from_, nearest, to_.position(t, k)).barycentric;
      to_.corner_uvs[t][k] = int(to_.uvs.size());
      to_.uvs.push_back(interpolate(b, [&](int c) { return from_.uv(nearest, c); }));
    }
    to_.textures[t] = texture(nearest);
  }

 private:
  int texture(int triangle) const {
    const int own = from_.texture(triangle);
    return own < 0 ? own : first_texture_ + own;
  }

  const Mesh& from_;
  Mesh& to_;
  int first_uv_, first_texture_;
};

}  // namespace

Mesh textured(const Remeshed& found, const Mesh& of_template, const Mesh& target,
              int template_textures) {
  Mesh mesh = found.mesh;
  mesh.corner_uvs.assign(mesh.triangles.size(), {-1, -1, -1});
  mesh.textures.assign(mesh.triangles.size(), -1);
  Atlas old(of_template, 0, mesh), fresh(target, template_textures, mesh);
  std::vector<int> made[2];  // triangles between, by whether they show the target
  std::vector<Vector3> middles[2];
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (found.template_triangles[t] >= 0) {
      old.take_over(t, found.template_triangles[t]);
    } else if (found.target_triangles[t] >= 0) {
      fresh.take_over(t, found.target_triangles[t]);
    } else {
      const int side = std::ranges::any_of(mesh.triangles[t],
                                           [&](int v) { return found.origins[v].of_target != 0; });
      made[side].push_back(t);
      middles[side].push_back((mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) /
                              3);
    }
  }
  for (const int side : {0, 1}) {
    if (made[side].empty()) continue;
    const std::vector<ClosestPoint> nearest =
        ClosestPointFinder(side ? target : of_template)(middles[side]);
    for (std::size_t i = 0; i < nearest.size(); ++i)
      (side ? fresh : old).look_up(made[side][i], nearest[i].triangle);
  }
  return mesh;
}

}  // namespace mq
