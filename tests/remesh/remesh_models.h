#pragma once
/// Pairs of surfaces for remeshing, and what must hold of every result.

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "fixtures.h"
#include "mq/base/random.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface.h"
#include "mq/remesh/detail/clip_crossings.h"
#include "mq/remesh/remesh.h"
#include "mq/sample/implicit.h"

namespace mq::test {

/// The mesh with positions mapped.
template <class Map>
Mesh mapped(Mesh mesh, const Map& map) {
  for (Vector3& p : mesh.positions) p = map(p);
  return mesh;
}

/// Without the triangles around these vertices, and without UVs.
inline Mesh without(Mesh mesh, const std::set<int>& vertices) {
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return std::ranges::any_of(t, [&](int v) { return vertices.contains(v); });
  });
  return mesh;
}

inline Mesh with_flipped(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

inline std::string topology_problems(const Mesh& mesh) {
  const Surface surface = make_surface(mesh, {WeldOptions::Kind::none});
  std::string problems;
  for (const Defect& defect : surface.defects)
    if (defect.kind != "unreferenced_vertices")
      problems += defect.kind + " " + std::to_string(defect.count) + "; ";
  return problems;
}

inline bool is_closed(const Surface& surface) { return surface.boundary_edges == 0; }

/// What is wrong with a result, in words; empty where nothing is.
inline std::string problems(const Surface& of_template, const Surface& target,
                            const Remeshed& found) {
  const Mesh& mesh = found.mesh;
  std::string all = topology_problems(mesh);
  const Surface result = make_surface(mesh, {WeldOptions::Kind::none});
  if (is_closed(of_template) && is_closed(target) && result.boundary_edges != 0)
    all += std::to_string(result.boundary_edges) + " boundary edges; ";
  if (found.kept + found.removed != of_template.triangle_count())
    all += "kept and died do not add up; ";
  if (found.kept + found.added != mesh.triangle_count()) all += "kept and born do not add up; ";
  int moved = 0, thin = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int source = found.template_triangles[std::size_t(t)];
    for (int k = 0; k < 3 && source >= 0; ++k) {
      const int v = mesh.triangles[std::size_t(t)][std::size_t(k)];
      moved += mesh.position(t, k) != of_template.mesh.position(source, k);
      moved += found.template_vertices[std::size_t(v)] !=
               of_template.mesh.triangles[std::size_t(source)][std::size_t(k)];
    }
    if (source >= 0 || found.target_triangles[std::size_t(t)] >= 0) continue;
    const Vector3 &a = mesh.position(t, 0), &b = mesh.position(t, 1), &c = mesh.position(t, 2);
    const double longest =
        std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()});
    thin += !(2 * triangle_area(mesh, t) > 1e-4 * longest);
  }
  if (moved > 0) all += std::to_string(moved) + " corners of kept triangles moved; ";
  if (thin > 0) all += std::to_string(thin) + " triangles without area; ";
  return all;
}

/// Triangles made along seams whose normals point away from those of both surfaces nearby.
inline int turned_triangles(const Surface& of_template, const Surface& target,
                            const Remeshed& found) {
  const ClosestPointFinder on_template(of_template.mesh), on_target(target.mesh);
  int turned = 0;
  for (int t = 0; t < found.mesh.triangle_count(); ++t) {
    if (found.template_triangles[std::size_t(t)] >= 0 ||
        found.target_triangles[std::size_t(t)] >= 0)
      continue;
    const Vector3 middle =
        (found.mesh.position(t, 0) + found.mesh.position(t, 1) + found.mesh.position(t, 2)) / 3;
    const Vector3 normal = triangle_normal(found.mesh, t);
    turned += normal.dot(triangle_normal(of_template.mesh, on_template(middle).triangle)) < 0 &&
              normal.dot(triangle_normal(target.mesh, on_target(middle).triangle)) < 0;
  }
  return turned;
}

inline double torus_distance(const Vector3& p, double large, double small) {
  return std::hypot(std::hypot(p.x(), p.y()) - large, p.z()) - small;
}

inline double ball(const Vector3& p, const Vector3& center, double radius) {
  return (p - center).norm() - radius;
}

inline double capsule(const Vector3& p, const Vector3& a, const Vector3& b, double radius) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm() - radius;
}

inline double ellipsoid(const Vector3& p, const Vector3& center, const Vector3& radii) {
  const Vector3 q = (p - center).cwiseQuotient(radii);
  const double gradient = q.cwiseQuotient(radii).norm();
  return gradient > 1e-12 ? q.norm() * (q.norm() - 1) / gradient : -radii.minCoeff();
}

inline Mesh meshed(const Solid& solid, int triangles, int euler_characteristic) {
  return mesh_of_solid(solid,
                       {.triangles = triangles, .euler_characteristic = euler_characteristic});
}

/// A body with a head, arms, legs and a skin that is not smooth; and the same with a handle on its
/// back.
inline double figure(const Vector3& p) {
  double d = ellipsoid(p, {0, 0, 0}, {0.42, 0.6, 0.33});
  d = smooth_union(d, ellipsoid(p, {0, 0.72, 0}, {0.2, 0.22, 0.2}), 0.08);
  d = smooth_union(d, capsule(p, {0.3, 0.3, 0}, {0.65, 0.05, 0.15}, 0.09), 0.06);
  d = smooth_union(d, capsule(p, {-0.3, 0.3, 0}, {-0.65, 0.55, 0.1}, 0.09), 0.06);
  d = smooth_union(d, capsule(p, {0.2, -0.4, 0}, {0.25, -0.85, 0.05}, 0.12), 0.06);
  d = smooth_union(d, capsule(p, {-0.2, -0.4, 0}, {-0.25, -0.85, 0.05}, 0.12), 0.06);
  return d + 0.006 * std::sin(25 * p.x()) * std::sin(22 * p.y() + 1) * std::sin(24 * p.z());
}
inline double figure_with_handle(const Vector3& p) {
  const Vector3 q = p - Vector3(0, 0.1, -0.36);
  return smooth_union(figure(p), torus_distance({q.y(), q.z(), q.x()}, 0.16, 0.035), 0.02);
}

/// A ball, and the same with a handle on top.
inline double plain(const Vector3& p) { return ball(p, {0, -0.2, 0}, 0.6); }
inline double handled(const Vector3& p) {
  return smooth_union(plain(p), torus_distance(p - Vector3(0, 0.4, 0), 0.2, 0.06), 0.03);
}

/// A ring, and the same with its hole plugged.
inline double ring(const Vector3& p) { return torus_distance(p, 0.55, 0.25); }
inline double plugged(const Vector3& p) {
  return smooth_union(ring(p), ball(p, {0, 0, 0}, 0.33), 0.05);
}

/// Two balls side by side, apart or joined by a neck.
inline double apart(const Vector3& p) {
  return std::min(ball(p, {-0.45, 0, 0}, 0.38), ball(p, {0.45, 0, 0}, 0.38));
}
inline double joined(const Vector3& p) {
  return smooth_union(apart(p), capsule(p, {-0.45, 0, 0}, {0.45, 0, 0}, 0.15), 0.05);
}

/// Random numbers one after the other.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) { return random_.uniform(count_++, low, high); }
  int below(int n) { return int(between(0, n)); }

 private:
  Random random_;
  std::uint64_t count_ = 0;
};

/// One smooth piece: a sphere or torus with waves, stretched, turned, sometimes with holes, or a
/// sheet.
inline Mesh random_piece(Dice& dice) {
  const int kind = dice.below(7);
  Mesh mesh = kind < 4   ? fixtures::sphere(1 + dice.below(4))
              : kind < 6 ? fixtures::torus(8 + dice.below(30), 6 + dice.below(14), 1,
                                           dice.between(0.2, 0.6))
                         : fixtures::flat_square(3 + dice.below(14), 0.2);
  const double wave = dice.between(0, 0.15), many = dice.between(1, 4), phase = dice.between(0, 6);
  const Vector3 stretch(dice.between(0.4, 1.2), dice.between(0.4, 1.2), dice.between(0.4, 1.2));
  const Vector3 shift(dice.between(-1, 1), dice.between(-1, 1), dice.between(-1, 1));
  const double a = dice.between(0, 6), b = dice.between(0, 6);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  mesh = mapped(std::move(mesh), [&](Vector3 p) {
    p *= 1 + wave * std::sin(many * p.x() + phase) * std::cos(many * p.y());
    p = p.cwiseProduct(stretch);
    p = {std::cos(a) * p.x() - std::sin(a) * p.y(), std::sin(a) * p.x() + std::cos(a) * p.y(),
         p.z()};
    p = {p.x(), std::cos(b) * p.y() - std::sin(b) * p.z(),
         std::sin(b) * p.y() + std::cos(b) * p.z()};
    return Vector3(p + shift);
  });
  std::set<int> holes;
  for (int i = dice.below(8) - 5; i > 0; --i) holes.insert(dice.below(mesh.vertex_count()));
  return without(std::move(mesh), holes);
}

inline Mesh random_model(Dice& dice) {
  Mesh mesh = random_piece(dice);
  for (int i = dice.below(3); i > 0; --i) mesh = fixtures::beside(mesh, random_piece(dice));
  return mesh;
}

/// The mesh with triangles repeated, turned over and collapsed and vertices joined: no surface.
inline Mesh corrupted(Mesh mesh, Dice& dice) {
  for (int i = dice.below(6); i >= 0; --i) {
    const int count = mesh.triangle_count();
    Triangle& t = mesh.triangles[std::size_t(dice.below(count))];
    const Triangle other = mesh.triangles[std::size_t(dice.below(count))];
    switch (dice.below(5)) {
      case 0: mesh.triangles.push_back(other); break;
      case 1: std::swap(t[0], t[1]); break;
      case 2:
        for (Triangle& each : mesh.triangles) std::ranges::replace(each, int(t[0]), int(other[0]));
        break;
      case 3: t[1] = t[0]; break;
      default: t[2] = other[0];
    }
  }
  return mesh;
}

/// How many triangles cross others.
inline std::int64_t crossings(const Mesh& mesh) {
  return std::ranges::count(crossed(mesh.positions, mesh.triangles, {}), char(1));
}

/// A template and a target that have something, or nothing, to do with each other.
inline std::array<Mesh, 2> random_pair(std::uint64_t seed) {
  Dice dice(seed);
  const Mesh first = random_model(dice);
  const Vector3 at = first.positions[std::size_t(dice.below(first.vertex_count()))];
  const double size = dice.between(0.1, 0.6), height = dice.between(-0.4, 0.4);
  const auto bump = [&](const Vector3& p) {
    return Vector3(p + height * std::exp(-(p - at).squaredNorm() / (size * size)) *
                           Vector3(0.6, 0.64, 0.48));
  };
  switch (dice.below(9)) {
    case 0: return {first, random_model(dice)};
    case 1: return {first, mapped(first, bump)};
    case 2: return {first, fixtures::beside(first, random_piece(dice))};
    case 3: return {fixtures::beside(first, random_piece(dice)), first};
    case 4:
      return {first, mapped(first, [&](const Vector3& p) { return Vector3(p * (1 + height)); })};
    case 5:
      return {first, mapped(first, [&](const Vector3& p) {
                return Vector3(p + Vector3(height, 0, size) * 0.1);
              })};
    case 6:
      return {first, mapped(random_model(dice), [&](const Vector3& p) {
                return Vector3(p * std::pow(10, 8 * height));
              })};
    case 7: {
      std::set<int> hole{dice.below(first.vertex_count())};
      for (int i = 0; i < first.vertex_count(); ++i)
        if ((first.positions[std::size_t(i)] - at).norm() < size) hole.insert(i);
      const Mesh open = without(first, hole);
      if (open.triangles.empty()) return {first, first};
      return dice.below(2) ? std::array{first, open} : std::array{open, mapped(first, bump)};
    }
    default:
      return {first, mapped(first, [&](const Vector3& p) {
                return Vector3(bump(p) + Vector3::Constant(0.003 * std::sin(40 * p.x())));
              })};
  }
}

}  // namespace mq::test
