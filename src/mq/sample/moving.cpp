// A frame is the surface f(φ⁻¹(p)) = 0, f the solid at rest and φ the motion, which has an inverse
// in closed form; the mesher sees another grid in each. A vertex p has the material φ⁻¹(p).
//
// Bending is Barr's (Global and local deformations of solid primitives, 1984): the segment x = 0 of
// the y axis becomes an arc of curvature k, planes across it stay planes:
//
//     θ = k y,   (x, y) ↦ (1/k − (1/k − x) cos θ, (1/k − x) sin θ).

#include "mq/sample/moving.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/options.h"
#include "mq/base/parallel.h"
#include "mq/base/random.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/implicit.h"
#include "mq/sample/paint.h"

namespace mq {
namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr double handle_edges = 3, hole_edges = 2;  // radii

/// A long body with a belly, flatter than wide, a nose on one side.
double long_body(const Vector3& p) {
  const double y = std::clamp(p.y(), -0.8, 0.8);
  const double belly = 0.30 + 0.06 * std::cos(2.5 * y + 0.6);
  const double trunk = Vector3(p.x(), p.y() - y, 1.25 * p.z()).norm() - belly;
  const double nose = (p - Vector3(0.05, 0.55, 0.3)).norm() - 0.13;
  return smooth_union(trunk, nose, 0.15);
}

double vase(const Vector3& p) {
  const double y = std::clamp(p.y(), -0.7, 0.7);
  const double radius = 0.38 + 0.12 * std::sin(4 * y);
  return 0.8 * (std::hypot(std::hypot(p.x(), p.z()) / radius * 0.4, p.y() - y) - 0.4);
}

constexpr double ball_radius = 0.45;

Vector3 turned(const Vector3& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() + s * p.z(), p.y(), c * p.z() - s * p.x()};
}

Vector3 bent(const Vector3& p, double k) {
  if (std::abs(k) < 1e-9) return p;
  const double rest = 1 / k - p.x(), angle = k * p.y();
  return {1 / k - rest * std::cos(angle), rest * std::sin(angle), p.z()};
}

Vector3 unbent(const Vector3& p, double k) {
  if (std::abs(k) < 1e-9) return p;
  const double sign = k > 0 ? 1 : -1;
  const double angle = std::atan2(sign * p.y(), sign * (1 / k - p.x()));
  return {1 / k - sign * std::hypot(p.y(), 1 / k - p.x()), angle / k, p.z()};
}

/// Half the distance of the balls' centres.
double apart(double s) { return 0.52 + 0.18 * std::cos(turn * s); }

/// A motion and its inverse at the phase s of the period, 0 to 1.
struct Motion {
  SampleInfo info;
  double (*solid)(const Vector3& p, double s);  // in space, already moved
  Vector3 (*to_rest)(const Vector3& p, double s);
  Vector3 (*from_rest)(const Vector3& p, double s);
  std::vector<int> (*euler_characteristics)(double s) = [](double) { return std::vector{2}; };
};

double curvature(double s) { return 1.3 * std::sin(turn * s); }
double torsion(double s) { return 1.2 * std::sin(turn * s); }

const std::vector<Motion>& motions() {
  static const std::vector<Motion> all = {
      {{"bending", "a long body bends to both sides"},
       [](const Vector3& p, double s) { return long_body(unbent(p, curvature(s))); },
       [](const Vector3& p, double s) { return unbent(p, curvature(s)); },
       [](const Vector3& p, double s) { return bent(p, curvature(s)); }},
      {{"twisting", "the same twists both ways"},
       [](const Vector3& p, double s) { return long_body(turned(p, -torsion(s) * p.y())); },
       [](const Vector3& p, double s) { return turned(p, -torsion(s) * p.y()); },
       [](const Vector3& p, double s) { return turned(p, torsion(s) * p.y()); }},
      {{"spinning", "a vase turns about its axis, of which only colours tell"},
       [](const Vector3& p, double) { return vase(p); },
       [](const Vector3& p, double s) { return turned(p, -turn * s); },
       [](const Vector3& p, double s) { return turned(p, turn * s); }},
      {{"merging", "two balls fuse and part"},
       [](const Vector3& p, double s) {
         const Vector3 half(apart(s), 0, 0);
         return smooth_union((p - half).norm() - ball_radius, (p + half).norm() - ball_radius, 0.2);
       },
       [](const Vector3& p, double s) {
         return Vector3(p + Vector3(p.x() > 0 ? apart(0) - apart(s) : apart(s) - apart(0), 0, 0));
       },
       [](const Vector3& p, double s) {
         return Vector3(p - Vector3(p.x() > 0 ? apart(0) - apart(s) : apart(s) - apart(0), 0, 0));
       },
       // Where smooth_union of two planes at equal distance d is 0: d = k/4.
       [](double s) {
         return apart(s) - ball_radius > 0.05 ? std::vector{4, 2} : std::vector{2, 4};
       }}};
  return all;
}

const Motion& find_motion(const std::string& name) {
  std::vector<std::string> names;
  for (const Motion& motion : motions()) {
    if (motion.info.name == name) return motion;
    names.push_back(motion.info.name);
  }
  throw InvalidInput(fmt::format("there is no sequence '{}'{}", name, did_you_mean(name, names)));
}

double phase(double frame, const MovingOptions& options) {
  const double periods = frame / options.period;
  return periods - std::floor(periods);
}

ImplicitOptions grid_of(int frame, const MovingOptions& options) {
  const Random random(options.seed, 17);
  ImplicitOptions implicit{
      .low = {-1.35, -1.35, -0.75}, .high = {1.35, 1.35, 0.75}, .triangles = options.triangles};
  for (int k = 0; k < 3; ++k)
    implicit.low[k] -= random.uniform(std::uint64_t(3 * frame + k), 0, 0.2);
  return implicit;
}

/// Where the topology is about to change, the grid may not show the one the formula says.
Mesh mesh_at(const Motion& motion, double s, int frame, const MovingOptions& options,
             const Progress& progress) {
  ImplicitOptions implicit = grid_of(frame, options);
  const auto solid = [&](const Vector3& p) { return motion.solid(p, s); };
  const std::vector<int> euler_characteristics = motion.euler_characteristics(s);
  for (const int euler : euler_characteristics) {
    implicit.euler_characteristic = euler;
    try {
      return mesh_of_solid(solid, implicit, progress);
    } catch (const InvalidInput&) {
      if (euler == euler_characteristics.back()) throw;
    }
  }
  return {};
}

/// The frame with handles where they flicker, as many of them as its grid can show.
Mesh with_flickering_handles(const Mesh& clean, const Motion& motion, double s, int frame,
                             const MovingOptions& options) {
  const Surface surface = make_surface(clean);
  const std::vector<Vector3> normals = vertex_normals(clean);
  const double radius = handle_edges * mean_edge_length(surface);
  std::vector<Vector3> material, places, upward;
  for (const Vector3& p : clean.positions) material.push_back(motion.to_rest(p, s));
  for (const int v : flickering_vertices(material, options.capture.handles, frame, options.seed + 1)) {
    if (std::ranges::any_of(places, [&](const Vector3& p) { return (p - clean.positions[v]).norm() < 4 * radius; }))
      continue;
    places.push_back(clean.positions[v]), upward.push_back(normals[v]);
  }
  ImplicitOptions implicit = grid_of(frame, options);
  implicit.triangles = clean.triangle_count();
  for (; !places.empty(); places.pop_back(), upward.pop_back()) {
    implicit.euler_characteristic = surface.euler_characteristic - 2 * int(places.size());
    try {
      return mesh_of_solid(with_handles([&](const Vector3& p) { return motion.solid(p, s); }, places, upward, radius),
                           implicit);
    } catch (const InvalidInput&) {
    }
  }
  return clean;
}

/// Takes triangles out where holes flicker, and vertices that none is left at.
void cut_holes(int frame, const MovingOptions& options, MovingFrame& made) {
  std::vector<Vector3> places;
  for (const int v : flickering_vertices(made.material, options.capture.holes, frame, options.seed))
    places.push_back(made.mesh.positions[v]);
  const double edge = mean_edge_length(make_surface(made.mesh));
  const std::vector<char> left = left_by_holes(made.mesh, places, hole_edges * edge);
  std::vector<int> vertex(made.mesh.positions.size(), -1);
  MovingFrame rest;
  for (std::size_t t = 0; t < left.size(); ++t) {
    if (!left[t]) continue;
    Triangle corners = made.mesh.triangles[t];
    for (int& v : corners) {
      if (vertex[v] < 0) {
        vertex[v] = rest.mesh.vertex_count();
        rest.mesh.positions.push_back(made.mesh.positions[v]);
        rest.material.push_back(made.material[v]);
        rest.colors.push_back(made.colors[v]);
      }
      v = vertex[v];
    }
    rest.mesh.triangles.push_back(corners);
  }
  made = std::move(rest);
}

/// Where a light comes from: around the axis of the body, from a little above.
Vector3 light_direction(int frame) {
  const double angle = turn * frame / light_period, height = 0.4;
  return Vector3(std::cos(angle), height, std::sin(angle)).normalized();
}

void light(const Mesh& mesh, int frame, double strength, std::vector<Vector3>& colors) {
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const Vector3 direction = light_direction(frame);
  for (std::size_t v = 0; v < colors.size(); ++v)
    colors[v] *= 1 - strength * 0.5 * (1 - normals[v].dot(direction));
}

/// Exposure of a frame: numbers of variance 1, alike within a camera's view and within a wave.
class Exposure {
 public:
  Exposure(int frame, const MovingOptions& options) : random_(options.seed, 500000 + std::uint64_t(frame)) {
    whole_ = number();
    for (Vector3& gain : cameras_) gain = {number(), number(), number()};
    for (auto& [wave, shift] : waves_) {
      const double up = uniform(-1, 1), around = uniform(0, turn), across = std::sqrt(1 - up * up);
      wave = turn / flicker_wave * Vector3(across * std::cos(around), up, across * std::sin(around));
      shift = uniform(0, turn);
    }
  }

  /// Of the three channels at a place.
  Vector3 operator()(const Vector3& p, const Vector3& normal) const {
    Vector3 seen = Vector3::Zero();
    double squares = 0, wave = 0;
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      const Vector3 from(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      const double faces = std::max(0.0, normal.dot(from)), weight = faces * faces;
      seen += weight * cameras_[k];
      squares += weight * weight;
    }
    for (const auto& [k, shift] : waves_) wave += std::cos(k.dot(p) + shift);
    return (seen / std::sqrt(std::max(squares, 1e-12))).array() + whole_ + wave * std::sqrt(2.0 / double(waves_.size()));
  }

 private:
  double uniform(double low, double high) { return random_.uniform(count_++, low, high); }
  double number() { return uniform(-std::sqrt(3.0), std::sqrt(3.0)); }

  Random random_;
  std::uint64_t count_ = 0;
  double whole_ = 0;
  std::array<Vector3, 8> cameras_;
  std::array<std::pair<Vector3, double>, 6> waves_;
};

void expose(const Mesh& mesh, int frame, const MovingOptions& options, std::vector<Vector3>& colors) {
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const Exposure exposure(frame, options);
  for (std::size_t v = 0; v < colors.size(); ++v) {
    const Vector3 logarithm = options.flicker / std::sqrt(3.0) * exposure(mesh.positions[v], normals[v]);
    colors[v].array() *= logarithm.array().exp();
  }
}

/// Evenly distributed, a different one in every frame.
void add_noise(int frame, const MovingOptions& options, std::vector<Vector3>& colors) {
  const Random random(options.seed, 1000 + std::uint64_t(frame));
  const double width = options.noise * std::sqrt(3.0);
  for (std::size_t v = 0; v < colors.size(); ++v)
    for (int c = 0; c < 3; ++c) colors[v][c] += random.uniform(3 * v + c, -width, width);
}

}  // namespace

const std::vector<SampleInfo>& moving_names() {
  static const std::vector<SampleInfo> all = [] {
    std::vector<SampleInfo> infos;
    for (const Motion& motion : motions()) infos.push_back(motion.info);
    return infos;
  }();
  return all;
}

MovingFrame make_moving_frame(const std::string& name, int frame, const MovingOptions& options,
                              const Progress& progress) {
  const Motion& motion = find_motion(name);
  require(frame >= 0 && options.period >= 1,
          fmt::format("frame {} of a motion of {} frames was asked for: both must be positive",
                      frame, options.period));
  require(
      options.triangles >= 500 && options.triangles <= 20000000,
      fmt::format("{} triangles were asked for: 500 to 20 million are made", options.triangles));
  require(options.light >= 0 && options.light <= 1 && options.noise >= 0 && options.flicker >= 0,
          fmt::format("light of {}, noise of {} and flicker of {} were asked for: light is from 0 to 1, the others at "
                      "least 0",
                      options.light, options.noise, options.flicker));
  const CheapCapture& capture = options.capture;
  require(capture.off >= 0 && capture.off <= 1 && std::min(capture.holes, capture.handles) >= 0 &&
              std::max(capture.holes, capture.handles) <= 1000,
          fmt::format("vertices off by {} edges, {} holes and {} handles were asked for: 0 to 1, and "
                      "0 to 1000",
                      capture.off, capture.holes, capture.handles));
  const double s = phase(frame, options);
  MovingFrame result;
  result.mesh = mesh_at(motion, s, frame, options, progress);
  if (capture.handles > 0)
    result.mesh = with_flickering_handles(result.mesh, motion, s, frame, options);
  const ColorField field = colorful(0.35, options.seed);
  result.material.resize(result.mesh.positions.size());
  result.colors.resize(result.mesh.positions.size());
  parallel_for(result.mesh.vertex_count(), [&](std::int64_t v) {
    result.material[v] = motion.to_rest(result.mesh.positions[v], s);
    result.colors[v] = field(result.material[v], 0).cwiseMax(0).cwiseMin(1);
  });
  if (options.light > 0) light(result.mesh, frame, options.light, result.colors);
  if (options.flicker > 0) expose(result.mesh, frame, options, result.colors);
  if (options.noise > 0) add_noise(frame, options, result.colors);
  for (Vector3& color : result.colors) color = color.cwiseMax(0).cwiseMin(1);
  displace(capture.off, frame, options.seed, result.mesh);
  if (capture.holes > 0) cut_holes(frame, options, result);
  return result;
}

Vector3 moved_material(const std::string& name, const Vector3& material, double frame,
                       const MovingOptions& options) {
  return find_motion(name).from_rest(material, phase(frame, options));
}

}  // namespace mq
