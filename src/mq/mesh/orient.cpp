// Parts are found by walking over edges; a triangle's side, 0 or 1, says whether it is turned
// against the first of its part. The volume that a part encloses with cones from c,
//
//     V(c) = ⅙ Σ ⟨p − c, (q − c) × (r − c)⟩ = V(m) − ⅓ ⟨c − m, A⟩,   A = ½ Σ (q − p) × (r − p),
//
// depends on c only as far as the part is open: of a closed one A = 0.

#include "mq/mesh/orient.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <tuple>
#include <utility>

#include "mq/mesh/check.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

constexpr double least_part = 1e-3;   // of the area
constexpr double certainty = 10;      // of a volume, in how much it depends on what closes it
constexpr double near = 0.05;         // of the diagonal of what was before
constexpr double most_samples = 500;  // of a part, of which the nearest points are asked

/// A triangle at an edge, and whether it runs along it from the lower vertex to the higher.
struct Side {
  int low, high;           // welded
  std::pair<int, int> by;  // as the mesh has them, the lower first
  int triangle, forward;
};

/// Two triangles with one edge; 1: they turn against each other.
struct Neighbour {
  int triangle, against;
};

struct Part {
  std::vector<int> triangles;
  double area = 0, volume = 0;
  Vector3 vector_area = Vector3::Zero(), low, high;

  bool encloses() const {
    return std::abs(volume) >
           certainty / 6 * vector_area.cwiseAbs().dot(high - low) + 1e-9 * std::pow(area, 1.5);
  }
};

/// Per triangle those across its edges that have two triangles: of more that lie at one place, the
/// two that the mesh itself joins there, and two that are left.
std::vector<std::vector<Neighbour>> neighbours(const Mesh& mesh) {
  const std::vector<int> welded =
      weld_vertices(mesh, referenced_vertices(mesh), {.kind = WeldOptions::Kind::exact});
  std::vector<Side> sides;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const Triangle& v = mesh.triangles[t];
    const Triangle w = {welded[v[0]], welded[v[1]], welded[v[2]]};
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = w[k], b = w[(k + 1) % 3];
      sides.push_back(
          {std::min(a, b), std::max(a, b), std::minmax(v[k], v[(k + 1) % 3]), t, a < b});
    }
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.by, a.triangle) < std::tie(b.low, b.high, b.by, b.triangle);
  });
  std::vector<std::vector<Neighbour>> result(mesh.triangles.size());
  const auto join = [&](const Side& a, const Side& b) {
    const int against = a.forward == b.forward;
    result[a.triangle].push_back({b.triangle, against});
    result[b.triangle].push_back({a.triangle, against});
  };
  const auto end_of = [&](std::size_t i, auto&& same) {
    std::size_t j = i;
    while (j < sides.size() && same(sides[i], sides[j])) ++j;
    return j;
  };
  for (std::size_t i = 0; i < sides.size();) {
    const std::size_t end =
        end_of(i, [](const Side& a, const Side& b) { return a.low == b.low && a.high == b.high; });
    std::vector<std::size_t> left;
    if (end - i == 2) {
      join(sides[i], sides[i + 1]);
      i = end;
    }
    while (i < end) {
      const std::size_t j =
          std::min(end, end_of(i, [](const Side& a, const Side& b) { return a.by == b.by; }));
      if (j - i == 2)
        join(sides[i], sides[i + 1]);
      else
        for (; i < j; ++i) left.push_back(i);
      i = j;
    }
    if (left.size() == 2) join(sides[left[0]], sides[left[1]]);
  }
  return result;
}

/// The parts; in `turned` the smaller side of each.
std::vector<Part> parts_facing_alike(const Mesh& mesh, std::vector<char>& turned) {
  const std::vector<std::vector<Neighbour>> around = neighbours(mesh);
  const std::vector<double> areas = triangle_areas(mesh);
  std::vector<char> seen(mesh.triangles.size(), 0);
  std::vector<Part> parts;
  for (int first = 0; first < mesh.triangle_count(); ++first) {
    if (seen[first]) continue;
    Part part;
    part.triangles = {first};
    seen[first] = 1;
    double other_side = 0;
    std::int64_t before = 0, after = 0;  // edges that disagree
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
      const int t = part.triangles[i];
      part.area += areas[t];
      if (turned[t]) other_side += areas[t];
      for (const auto& [next, against] : around[t]) {
        if (!seen[next]) {
          seen[next] = 1;
          turned[next] = char(turned[t] ^ against);
          part.triangles.push_back(next);
        }
      }
    }
    for (const int t : part.triangles)
      for (const auto& [next, against] : around[t]) {
        before += against;
        after += turned[t] ^ turned[next] ^ against;
      }
    const bool stays = 2 * after > before, first_turns = 2 * other_side > part.area;
    for (const int t : part.triangles) turned[t] = stays ? 0 : turned[t] ^ first_turns;
    parts.push_back(std::move(part));
  }
  return parts;
}

void measure(Part& part, const Mesh& mesh) {
  part.low = part.high = mesh.position(part.triangles.front(), 0);
  for (const int t : part.triangles)
    for (int k = 0; k < 3; ++k) {
      part.low = part.low.cwiseMin(mesh.position(t, k));
      part.high = part.high.cwiseMax(mesh.position(t, k));
    }
  const Vector3 middle = 0.5 * (part.low + part.high);
  for (const int t : part.triangles) {
    const Vector3 p = mesh.position(t, 0) - middle, q = mesh.position(t, 1) - middle,
                  r = mesh.position(t, 2) - middle;
    part.volume += p.dot(q.cross(r)) / 6;
    part.vector_area += 0.5 * (q - p).cross(r - p);
  }
}

/// Whether a part winds around a point: its solid angle from there (Van Oosterom and Strackee 1983)
/// is nearer to ±4π than to 0.
bool winds_around(const Part& part, const Mesh& mesh, const Vector3& point) {
  if (((point - part.low).array() < 0).any() || ((part.high - point).array() < 0).any())
    return false;
  double angle = 0;
  for (const int t : part.triangles) {
    const Vector3 a = mesh.position(t, 0) - point, b = mesh.position(t, 1) - point,
                  c = mesh.position(t, 2) - point;
    const double x = a.norm(), y = b.norm(), z = c.norm();
    angle +=
        2 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
  }
  return std::abs(angle) > 2 * std::numbers::pi;
}

/// Whether a part faces against what is nearest to it.
bool faces_against(const Part& part, const Mesh& mesh, const Mesh& before,
                   const ClosestPointFinder& nearest, double reach) {
  const std::size_t stride = std::size_t(std::ceil(double(part.triangles.size()) / most_samples));
  double all = 0, close = 0, against = 0;
  for (std::size_t i = 0; i < part.triangles.size(); i += stride) {
    const int t = part.triangles[i];
    const double area = triangle_area(mesh, t);
    const Vector3 centre = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
    const ClosestPoint there = nearest(centre);
    all += area;
    if (there.squared_distance > reach * reach) continue;
    close += area;
    if (triangle_normal(mesh, t).dot(triangle_normal(before, there.triangle)) < 0) against += area;
  }
  return 2 * close >= all && 4 * against > 3 * close;
}

}  // namespace

Mesh with_flipped(Mesh mesh, const std::vector<int>& triangles) {
  for (const int t : triangles) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    if (mesh.has_uvs()) std::swap(mesh.corner_uvs[t][1], mesh.corner_uvs[t][2]);
  }
  return mesh;
}

Oriented oriented(const Mesh& mesh, const Mesh* before) {
  check_mesh(mesh);
  std::vector<char> turned(mesh.triangles.size(), 0);
  std::vector<Part> parts = parts_facing_alike(mesh, turned);
  const auto listed = [](const std::vector<char>& marked) {
    std::vector<int> list;
    for (std::size_t t = 0; t < marked.size(); ++t)
      if (marked[t]) list.push_back(int(t));
    return list;
  };
  Oriented result{.mesh = with_flipped(mesh, listed(turned)), .turned = {}, .defects = {}};
  std::vector<std::int64_t> scattered, whole;
  for (std::size_t t = 0; t < turned.size(); ++t)
    if (turned[t]) scattered.push_back(std::int64_t(t));

  double area = 0;
  for (const Part& part : parts) area += part.area;
  std::erase_if(parts, [&](const Part& part) { return !(part.area >= least_part * area); });
  for (Part& part : parts) measure(part, result.mesh);
  // What encloses most comes first, so that what lies inside of it follows it.
  std::ranges::stable_sort(
      parts, [](const Part& a, const Part& b) { return std::abs(a.volume) > std::abs(b.volume); });
  std::unique_ptr<ClosestPointFinder> nearest;
  std::vector<char> turns(parts.size(), 0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    if (part.encloses()) {
      std::size_t around = 0;
      while (around < i && !(parts[around].encloses() &&
                             winds_around(parts[around], result.mesh,
                                          result.mesh.position(part.triangles.front(), 0))))
        ++around;
      turns[i] = around < i ? turns[around] : part.volume < 0;
    } else if (before != nullptr) {
      if (!nearest) nearest = std::make_unique<ClosestPointFinder>(*before);
      turns[i] = faces_against(part, result.mesh, *before, *nearest,
                               near * bounding_box(*before).diagonal());
    }
  }
  std::vector<int> again;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (turns[i])
      for (const int t : parts[i].triangles) {
        turned[t] ^= 1;
        again.push_back(t);
        whole.push_back(t);
      }
  result.mesh = with_flipped(std::move(result.mesh), again);
  result.turned = listed(turned);
  std::ranges::sort(whole);
  add_defect(result.defects, "turned_triangles", Defect::Severity::warning, "triangle", scattered,
             "triangles faced against those beside them: they were flipped, so that each part "
             "faces one way",
             "facing against those beside them: flipped");
  add_defect(result.defects, "inside_out_triangles", Defect::Severity::warning, "triangle", whole,
             "triangles of parts that were inside out, or faced against what was there before, "
             "were flipped with their part",
             "of parts that were inside out: flipped with their part");
  return result;
}

Oriented oriented_like(const Mesh& mesh, const Mesh& before) {
  const Defects of_before = oriented(before).defects;
  if (std::ranges::count(of_before, "inside_out_triangles", &Defect::kind) > 0)
    return {.mesh = mesh, .turned = {}, .defects = {}};
  return oriented(mesh, &before);
}

}  // namespace mq
