// Embree walks a hierarchy of boxes around the triangles and leaves out those beyond the radius of
// the query. Everything it is given is in single precision, in coordinates where the mesh fills
// [-1, 1]: boxes are rounded outward, and the radius exceeds the best distance by more than what
// single precision can lose, so no triangle that could be closest is left out.

#include "mq/mesh/closest_point.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/embree.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Weight of b in the closest point of the segment a b, 0 to 1.
double along_segment(const Vector3& a, const Vector3& b, const Vector3& point) {
  const Vector3 e = b - a;
  const double length = e.squaredNorm();
  return length > 0 ? std::clamp((point - a).dot(e) / length, 0.0, 1.0) : 0.0;
}

/// Barycentric coordinates of the projection to the plane; not finite where there is none.
Vector3 in_plane(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& point) {
  const Vector3 normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  const double u = (c - b).cross(point - b).dot(normal) / area;
  const double v = (a - c).cross(point - c).dot(normal) / area;
  return {u, v, 1 - u - v};
}

constexpr float infinite = std::numeric_limits<float>::infinity();

float round_down(double x) { return std::nextafter(float(x), -infinite); }
float round_up(double x) { return std::nextafter(float(x), infinite); }

}  // namespace

ClosestPoint closest_point(const Mesh& mesh, int triangle, const Vector3& point) {
  const Vector3 &a = mesh.position(triangle, 0), &b = mesh.position(triangle, 1),
                &c = mesh.position(triangle, 2);
  const auto with_distance = [&](const Vector3& w) {
    return ClosestPoint{{triangle, w}, (w[0] * a + w[1] * b + w[2] * c - point).squaredNorm()};
  };
  const Vector3 inside = in_plane(a, b, c, point);
  if (inside.minCoeff() >= 0) return with_distance(inside);  // false for NaN
  ClosestPoint best{{triangle, {1, 0, 0}}, std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const double t = along_segment(mesh.position(triangle, k), mesh.position(triangle, l), point);
    Vector3 w = Vector3::Zero();
    w[k] = 1 - t;
    w[l] = t;
    const ClosestPoint candidate = with_distance(w);
    if (candidate.squared_distance < best.squared_distance) best = candidate;
  }
  return best;
}

struct ClosestPointFinder::Scene {
  const Mesh& mesh;
  Vector3 center;
  double unit = 1;  // half the largest extent, model units
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  struct Search {
    const Scene& scene;
    Vector3 point;
    const std::function<bool(const ClosestPoint&)>* accept = nullptr;  // null: all
    double most = std::numeric_limits<double>::infinity();             // squared distance
    ClosestPoint best{{}, std::numeric_limits<double>::infinity()};

    /// Whether the triangle is closer than all before.
    bool consider(int triangle) {
      const ClosestPoint found = closest_point(scene.mesh, triangle, point);
      const bool closer = found.squared_distance < best.squared_distance,
                 as_close = found.squared_distance == best.squared_distance;
      if (!closer && !(as_close && triangle < best.triangle)) return false;
      if (found.squared_distance > most || (accept != nullptr && !(*accept)(found))) return false;
      best = found;
      return closer;
    }

    /// Fills in `best`.
    void run();

    /// Beyond which no triangle matters, in units.
    float radius() const {
      const double slack = 1e-6 * (1 + scene.local(point).cwiseAbs().maxCoeff());
      const double least = std::min(best.squared_distance, most);
      return round_up(std::sqrt(least) / scene.unit * (1 + 1e-5) + slack);
    }
  };

  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const Scene& self = *static_cast<const Scene*>(arguments->geometryUserPtr);
    const int t = int(arguments->primID);
    Vector3 low = self.local(self.mesh.position(t, 0)), high = low;
    for (int k = 1; k < 3; ++k) {
      low = low.cwiseMin(self.local(self.mesh.position(t, k)));
      high = high.cwiseMax(self.local(self.mesh.position(t, k)));
    }
    RTCBounds& box = *arguments->bounds_o;
    box.lower_x = round_down(low.x()), box.upper_x = round_up(high.x());
    box.lower_y = round_down(low.y()), box.upper_y = round_up(high.y());
    box.lower_z = round_down(low.z()), box.upper_z = round_up(high.z());
  }

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    Search& search = *static_cast<Search*>(arguments->userPtr);
    if (!search.consider(int(arguments->primID))) return false;
    arguments->query->radius = search.radius();
    return true;
  }

  Vector3 local(const Vector3& p) const { return (p - center) / unit; }
};

void ClosestPointFinder::Scene::Search::run() {
  if (!point.allFinite())
    throw InvalidInput(
        fmt::format("({}, {}, {}) has no closest point", point.x(), point.y(), point.z()));
  const Vector3 local = scene.local(point);
  if (local.cwiseAbs().maxCoeff() > 1e9) {  // squares of single precision overflow, and all
    for (int t = 0; t < scene.mesh.triangle_count(); ++t) consider(t);  // triangles are as far
    return;
  }
  RTCPointQuery query{};
  query.x = float(local.x()), query.y = float(local.y()), query.z = float(local.z());
  query.radius = radius();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene.scene, &query, &context, &Scene::visit, this);
}

ClosestPointFinder::ClosestPointFinder(const Mesh& mesh) {
  require(mesh.triangle_count() > 0, "there is no closest point of a mesh without triangles");
  const Box box = bounding_box(mesh);
  require(box.low.allFinite() && box.high.allFinite(),
          "the closest point of a mesh needs finite positions");
  scene_.reset(new Scene{mesh, (box.low + box.high) / 2});
  scene_->unit = std::max((box.high - box.low).maxCoeff() / 2, 1e-300);
  scene_->device = rtcNewDevice(nullptr);
  if (scene_->device == nullptr) throw Unsupported("Embree does not start on this machine");
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, unsigned(mesh.triangle_count()));
  rtcSetGeometryUserData(geometry, scene_.get());
  rtcSetGeometryBoundsFunction(geometry, &Scene::bounds, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->scene);
}

ClosestPointFinder::~ClosestPointFinder() {
  if (!scene_) return;
  rtcReleaseScene(scene_->scene);
  rtcReleaseDevice(scene_->device);
}

ClosestPoint ClosestPointFinder::operator()(const Vector3& point) const {
  Scene::Search search{*scene_, point};
  search.run();
  return search.best;
}

ClosestPoint ClosestPointFinder::among(
    const Vector3& point, double radius,
    const std::function<bool(const ClosestPoint&)>& accept) const {
  Scene::Search search{*scene_, point, &accept, radius * radius};
  search.run();
  return search.best;
}

std::vector<ClosestPoint> ClosestPointFinder::operator()(
    std::span<const Vector3> points, std::span<const ClosestPoint> guesses) const {
  if (guesses.size() != points.size()) return (*this)(points);
  std::vector<ClosestPoint> found(points.size());
  parallel_for(std::ssize(points), [&](std::int64_t i) {
    Scene::Search search{*scene_, points[i]};
    const int guess = guesses[i].triangle;
    if (guess >= 0 && guess < scene_->mesh.triangle_count()) search.consider(guess);
    search.run();
    found[i] = search.best;
  });
  return found;
}

std::vector<ClosestPoint> ClosestPointFinder::operator()(std::span<const Vector3> points,
                                                         const Progress& progress) const {
  std::vector<ClosestPoint> found(points.size());
  parallel_blocks(std::ssize(points), 256, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t i = begin; i < end; ++i) found[i] = (*this)(points[i]);
  });
  progress.at(1);
  return found;
}

}  // namespace mq
