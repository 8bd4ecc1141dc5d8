// Embree is given the triangles in single precision, moved and scaled so that they fill [-1, 1].
// Near an edge it may name the neighbour of the triangle that the ray really meets, and on an edge
// either. From its answer a walk over the twins follows the ray in double: across the edge whose
// weight is most negative, until no weight is.

#include "mq/draw/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/mesh/embree.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Weights of the corners where the line meets the triangle's plane (Möller and Trumbore, 1997);
/// negative outside; not finite where the line lies in the plane.
Vector3 weights_on(const Mesh& mesh, int triangle, const Ray& ray) {
  const Vector3& a = mesh.position(triangle, 0);
  const Vector3 e1 = mesh.position(triangle, 1) - a, e2 = mesh.position(triangle, 2) - a;
  const Vector3 across = ray.direction.cross(e2), from = ray.origin - a;
  const double determinant = e1.dot(across);
  const double u = from.dot(across) / determinant;
  const double v = ray.direction.dot(from.cross(e1)) / determinant;
  return {1 - u - v, u, v};
}

Hit placed(const Mesh& mesh, int triangle, Vector3 weights) {
  weights = weights.cwiseMax(0.0);
  weights /= weights.sum();
  const SurfacePoint place{triangle, weights};
  return {place, point_at(mesh, place)};
}

constexpr int longest_walk = 8;

/// The edge opposite to the corner of smallest weight.
HalfEdge edge_across(int triangle, const Vector3& weights) {
  Eigen::Index corner = 0;
  weights.minCoeff(&corner);
  return 3 * triangle + (int(corner) + 1) % 3;
}

/// From the triangle Embree found to the one the ray meets; of two that share the edge it runs
/// through, the one of lower id.
Hit settle(const Surface& surface, int triangle, const Ray& ray) {
  const Mesh& mesh = surface.mesh;
  Vector3 weights = weights_on(mesh, triangle, ray);
  for (int step = 0; step < longest_walk && weights.allFinite(); ++step) {
    const double least = weights.minCoeff();
    if (least > 0) break;
    const HalfEdge twin = surface.twins[edge_across(triangle, weights)];
    if (twin < 0 || surface.degenerate[twin / 3]) break;
    const Vector3 beyond = weights_on(mesh, twin / 3, ray);
    // On an edge to the last bit both are right, and at a fold neither may be: stay unless better.
    const double there = beyond.minCoeff();
    if (!(there > least || (there == least && twin / 3 < triangle))) break;
    triangle = twin / 3;
    weights = beyond;
  }
  if (!weights.allFinite()) weights = Vector3::Constant(1 / 3.);
  return placed(mesh, triangle, weights);
}

}  // namespace

struct Scene::Hierarchy {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  Vector3 center = Vector3::Zero();
  double unit = 1;  // model units
  ~Hierarchy() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

Scene::Scene(const Surface& surface)
    : surface_(surface), hierarchy_(std::make_unique<Hierarchy>()) {
  const Mesh& mesh = surface.mesh;
  Hierarchy& h = *hierarchy_;
  h.device = rtcNewDevice(nullptr);
  if (h.device == nullptr) throw Unsupported("Embree does not start on this machine");
  h.scene = rtcNewScene(h.device);
  rtcSetSceneFlags(h.scene, RTC_SCENE_FLAG_ROBUST);
  const Box box = bounding_box(mesh);
  h.center = (box.low + box.high) / 2;
  h.unit = std::max(
      {(box.high - box.low).maxCoeff() / 2, 1e-9 * h.center.cwiseAbs().maxCoeff(), 1e-300});

  const RTCGeometry geometry = rtcNewGeometry(h.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), std::size_t(std::max(1, mesh.vertex_count()))));
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      positions[3 * v + k] = float((mesh.positions[v][k] - h.center[k]) / h.unit);
  auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
      std::size_t(std::max(1, mesh.triangle_count()))));
  std::fill(corners, corners + 3 * std::max(1, mesh.triangle_count()), 0u);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      corners[3 * t + k] = unsigned(mesh.triangles[t][surface.degenerate[t] ? 0 : k]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(h.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(h.scene);
  if (rtcGetDeviceError(h.device) != RTC_ERROR_NONE)
    throw Unsupported("Embree cannot hold the mesh: out of memory");
}

Scene::~Scene() = default;

Hit Scene::hit(const Ray& ray) const {
  const Hierarchy& h = *hierarchy_;
  // From just outside the sphere around the model, so that single precision is not spent on the
  // way.
  Vector3 origin = (ray.origin - h.center) / h.unit;
  origin += std::max(0.0, -origin.dot(ray.direction) - 2) * ray.direction;
  if (!(origin.squaredNorm() < 100)) return {};
  RTCRayHit query;
  query.ray.org_x = float(origin.x()), query.ray.org_y = float(origin.y());
  query.ray.org_z = float(origin.z());
  query.ray.dir_x = float(ray.direction.x()), query.ray.dir_y = float(ray.direction.y());
  query.ray.dir_z = float(ray.direction.z());
  query.ray.tnear = 0;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.time = 0, query.ray.mask = ~0u, query.ray.flags = 0;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  find_hit(h.scene, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return settle(surface_, int(query.hit.primID), ray);
}

}  // namespace mq
