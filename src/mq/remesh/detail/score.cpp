// s = d / tolerance · (1 − o + o·V) · (1 + c·κ̂). Rays are Embree's, in single precision and in
// coordinates where the mesh fills [-1, 1]; they leave a little above the surface, so that the
// triangles around the vertex are not hit by rounding. Directions are the same for all vertices up
// to the frame of the normal: a spiral of equal shares of cos θ sin θ dθ dφ.

#include "mq/remesh/detail/score.h"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/embree.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"

namespace mq {
namespace {

constexpr int rays = 64;
constexpr double largest_stretch = 3;  // of singular values, and of areas

/// A mesh that rays are shot at.
class RayScene {
 public:
  explicit RayScene(const Mesh& mesh) {
    const Box box = bounding_box(mesh);
    center_ = (box.low + box.high) / 2;
    unit_ = std::max((box.high - box.low).maxCoeff() / 2, 1e-300);
    device_.reset(rtcNewDevice(nullptr));
    if (!device_) throw Unsupported("Embree does not start on this machine");
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               std::size_t(mesh.vertex_count())));
    for (int v = 0; v < mesh.vertex_count(); ++v)
      for (int k = 0; k < 3; ++k)
        points[3 * std::size_t(v) + std::size_t(k)] = float(local(mesh.positions[v])[k]);
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), std::size_t(mesh.triangle_count())));
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k)
        corners[3 * std::size_t(t) + std::size_t(k)] = unsigned(mesh.triangles[t][k]);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_.get());
  }

  bool meets(const Vector3& from, const Vector3& direction) const {
    const Vector3 p = local(from);
    RTCRay ray{};
    ray.org_x = float(p.x()), ray.org_y = float(p.y()), ray.org_z = float(p.z());
    ray.dir_x = float(direction.x()), ray.dir_y = float(direction.y());
    ray.dir_z = float(direction.z());
    ray.tfar = 8;  // beyond anything in [-1, 1]³
    ray.mask = ~0U;
    return is_blocked(scene_.get(), ray);
  }

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  Vector3 local(const Vector3& p) const { return (p - center_) / unit_; }

  Vector3 center_;
  double unit_ = 1;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
};

std::array<Vector3, rays> cosine_spiral() {
  std::array<Vector3, rays> directions;
  for (int i = 0; i < rays; ++i) {
    const double r = std::sqrt((i + 0.5) / rays), a = i * std::numbers::pi * (3 - std::sqrt(5.0));
    directions[std::size_t(i)] = {r * std::cos(a), r * std::sin(a), std::sqrt(1 - r * r)};
  }
  return directions;
}

/// The larger singular value of a map of the plane over the smaller, and its determinant.
struct Stretch {
  double ratio = 1, area = 1;
};

Stretch stretch(const Mesh& mesh, const std::array<Vector3, 3>& rest, int t) {
  const auto flat = [](const Vector3& u, const Vector3& v) {
    Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
    const double length = u.norm();
    m.col(0) = Vector2(length, 0);
    if (length > 0) m.col(1) = Vector2(u.dot(v), u.cross(v).norm()) / length;
    return m;
  };
  const Vector3& now = mesh.position(t, 0);
  const Eigen::Matrix2d before = flat(rest[1] - rest[0], rest[2] - rest[0]);
  const Eigen::Matrix2d after = flat(mesh.position(t, 1) - now, mesh.position(t, 2) - now);
  if (!(before.determinant() > 0)) return {};  // nothing to compare with
  const Eigen::Matrix2d map = after * before.inverse();
  const double sum = map.squaredNorm(), det = map.determinant();
  const double root = std::sqrt(std::max(0.0, sum * sum - 4 * det * det));
  return {det > 0 ? std::sqrt((sum + root) / std::max(sum - root, 1e-300))
                  : std::numeric_limits<double>::infinity(),
          det};
}

}  // namespace

std::vector<double> visibility(const Surface& surface, std::span<const int> vertices,
                               const Progress& progress) {
  std::vector<double> seen(vertices.size(), 1);
  if (vertices.empty()) return seen;
  const RayScene scene(surface.mesh);
  std::vector<Vector3> normals = vertex_normals(surface.mesh);
  if (surface.boundary_edges == 0 && enclosed_volume(surface.mesh) < 0)
    for (Vector3& n : normals) n = -n;
  const std::array<Vector3, rays> directions = cosine_spiral();
  const double above = 1e-4 * bounding_box(surface.mesh).diagonal();
  parallel_blocks(std::ssize(vertices), 256, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t i = begin; i < end; ++i) {
      const int v = vertices[std::size_t(i)];
      const Vector3& normal = normals[std::size_t(v)];
      if (normal.isZero()) continue;
      const Vector3 u = normal.unitOrthogonal(), w = normal.cross(u);
      int free = 0;
      for (const Vector3& d : directions)
        free += !scene.meets(surface.mesh.positions[v] + above * normal,
                             d.x() * u + d.y() * w + d.z() * normal);
      seen[std::size_t(i)] = double(free) / rays;
    }
  });
  progress.at(1);
  return seen;
}

std::vector<char> distorted_triangles(const Mesh& mesh,
                                      std::span<const std::array<Vector3, 3>> rest) {
  require(std::ssize(rest) == mesh.triangle_count(),
          "the rest shape needs the corners of every triangle of the template");
  std::vector<char> distorted(mesh.triangles.size(), 0);
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    const Stretch found = stretch(mesh, rest[std::size_t(t)], int(t));
    distorted[std::size_t(t)] = found.ratio > largest_stretch || found.area > largest_stretch ||
                                found.area < 1 / largest_stretch;
  });
  return distorted;
}

Mismatch mismatch(const Surface& surface, const ClosestPointFinder& other,
                  const MismatchOptions& options, const Progress& progress) {
  require(options.tolerance > 0, "the tolerance of a mismatch must be above 0");
  Mismatch found;
  if (options.places.empty())
    found.places = other(surface.mesh.positions, progress.step("distances", 0.5));
  else
    found.places.assign(options.places.begin(), options.places.end());
  require(found.places.size() == surface.mesh.positions.size(), "a mismatch needs a place for every vertex");
  std::vector<char> used(surface.mesh.positions.size(), 0);
  for (const Triangle& t : surface.mesh.triangles)
    for (const int v : t) used[std::size_t(v)] = 1;

  std::vector<double>& scores = found.scores;
  scores.assign(surface.mesh.positions.size(), 0);
  std::vector<int> bending, modulated;
  for (std::size_t v = 0; v < scores.size(); ++v) {
    if (!used[v]) continue;
    scores[v] = std::sqrt(found.places[v].squared_distance) / options.tolerance;
    if (scores[v] * (1 + options.curvature) > options.least) bending.push_back(int(v));
  }
  const std::vector<PrincipalCurvatures> curvatures =
      options.curvature > 0
          ? vertex_curvatures(surface, bending, {.rings = 1}, progress.step("curvatures", 0.3))
          : std::vector<PrincipalCurvatures>(bending.size());
  const double h = mean_edge_length(surface);
  for (std::size_t i = 0; i < bending.size(); ++i) {
    double& score = scores[std::size_t(bending[i])];
    const double bent = std::max(std::abs(curvatures[i].max), std::abs(curvatures[i].min));
    score *= 1 + options.curvature * std::min(1.0, bent * h);
    if (score > options.least && options.occlusion > 0) modulated.push_back(bending[i]);
  }
  const std::vector<double> seen = visibility(surface, modulated, progress.step("visibility", 0.2));
  for (std::size_t i = 0; i < modulated.size(); ++i)
    scores[std::size_t(modulated[i])] *= 1 - options.occlusion * (1 - seen[i]);
  for (std::size_t v = 0; v < scores.size() && options.farthest > 0; ++v)
    if (used[v])
      scores[v] =
          std::max(scores[v], std::sqrt(found.places[v].squared_distance) / options.farthest);
  return found;
}

}  // namespace mq
