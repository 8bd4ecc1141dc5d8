// MikkTSpace by its description [mikkelsen2008wrinkled]: ∂p/∂u of the triangle with edges e₁, e₂ and
// texture edges (u₁, v₁), (u₂, v₂) points along w (v₂ e₁ − v₁ e₂), w = sign(u₁ v₂ − u₂ v₁).
//
// Corners that may share a tangent get one number; edges between corners of the same two numbers, in
// triangles of the same w, join the corners at both ends. What is joined is one group.
#include "mq/mesh/tangent_frames.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Any unit vector at right angles to a unit vector.
Vector3 across(const Vector3& n) {
  const Vector3 axis = std::abs(n.x()) < 0.6 ? Vector3::UnitX() : Vector3::UnitY();
  return (axis - axis.dot(n) * n).normalized();
}

/// The part of `v` in the plane of a unit vector, unit; 0 where there is hardly any.
Vector3 in_plane(const Vector3& v, const Vector3& n) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length)) return Vector3::Zero();
  const Vector3 part = v / length - (v / length).dot(n) * n;
  constexpr double least = 1e-6;
  return part.norm() > least ? Vector3(part.normalized()) : Vector3(Vector3::Zero());
}

bool is_known(const Eigen::Vector3f& v) { return v.allFinite() && v.squaredNorm() > 1e-20F; }

void complete_normals(const Mesh& mesh, std::vector<Eigen::Vector3f>& normals) {
  normals.resize(3 * std::size_t(mesh.triangle_count()), Eigen::Vector3f::Zero());
  std::vector<Vector3> of_vertices;
  if (!std::ranges::all_of(normals, is_known)) of_vertices = vertex_normals(mesh);
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3f& normal = normals[std::size_t(3 * t + k)];
      if (is_known(normal)) {
        normal = normal.cast<double>().normalized().cast<float>();
        continue;
      }
      Vector3 found = of_vertices[std::size_t(mesh.triangles[std::size_t(t)][k])];
      if (found.isZero()) found = triangle_normal(mesh, int(t));
      normal = (found.isZero() ? Vector3(Vector3::UnitZ()) : found).cast<float>();
    }
  });
}

/// Of one triangle: w, 0 where it has no area in the texture, and the direction of ∂p/∂u.
struct TextureAxes {
  int sign = 0;
  Vector3 along = Vector3::Zero();
};

TextureAxes texture_axes(const Mesh& mesh, int t) {
  if (!mesh.textured(t)) return {};
  const Vector2 a = mesh.uv(t, 1) - mesh.uv(t, 0), b = mesh.uv(t, 2) - mesh.uv(t, 0);
  const double area = cross(a, b);
  if (!std::isfinite(area) || area == 0) return {};
  const int sign = area > 0 ? 1 : -1;
  const Vector3 e = mesh.position(t, 1) - mesh.position(t, 0);
  const Vector3 f = mesh.position(t, 2) - mesh.position(t, 0);
  const Vector3 along = double(sign) * (b.y() * e - a.y() * f);
  if (!(along.norm() > 0)) return {};
  return {sign, along.normalized()};
}

/// What corners of one number agree in.
using CornerKey = std::array<double, 8>;

CornerKey corner_key(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, int corner) {
  const Vector3& p = mesh.position(corner / 3, corner % 3);
  const Eigen::Vector3f& n = normals[std::size_t(corner)];
  Vector2 uv = mesh.textured(corner / 3) ? mesh.uv(corner / 3, corner % 3) : Vector2(0, 0);
  if (!uv.allFinite()) uv.setZero();
  return {p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), uv.x(), uv.y()};
}

/// Per corner a number that corners of equal keys share.
std::vector<int> numbered(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals) {
  std::vector<std::pair<CornerKey, int>> corners(normals.size());
  parallel_for(std::ssize(corners), [&](std::int64_t c) {
    corners[std::size_t(c)] = {corner_key(mesh, normals, int(c)), int(c)};
  });
  std::ranges::sort(corners);
  std::vector<int> numbers(corners.size());
  int number = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i > 0 && corners[i].first != corners[i - 1].first) ++number;
    numbers[std::size_t(corners[i].second)] = number;
  }
  return numbers;
}

/// Sets that are joined; each goes by its lowest member.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int i) {
    while (parent_[std::size_t(i)] != i) {
      int& above = parent_[std::size_t(i)];
      above = parent_[std::size_t(above)];
      i = above;
    }
    return i;
  }
  void join(int a, int b) {
    a = find(a), b = find(b);
    parent_[std::size_t(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

Groups groups_of(const std::vector<int>& numbers, const std::vector<TextureAxes>& axes) {
  struct Edge {
    int low, high, sign;  ///< numbers of its ends, and w
    int at_low, at_high;  ///< corners
    auto ends() const { return std::tuple(low, high, sign); }
  };
  std::vector<Edge> edges;
  edges.reserve(numbers.size());
  for (int c = 0; c < int(numbers.size()); ++c) {
    const int sign = axes[std::size_t(c / 3)].sign;
    if (sign == 0) continue;
    const int d = next(c);
    const bool in_order = numbers[std::size_t(c)] <= numbers[std::size_t(d)];
    const int a = in_order ? c : d, b = in_order ? d : c;
    edges.push_back({numbers[std::size_t(a)], numbers[std::size_t(b)], sign, a, b});
  }
  std::ranges::stable_sort(edges, {}, &Edge::ends);
  Groups groups(numbers.size());
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (edges[i].ends() != edges[i - 1].ends()) continue;
    groups.join(edges[i].at_low, edges[i - 1].at_low);
    groups.join(edges[i].at_high, edges[i - 1].at_high);
  }
  return groups;
}

/// The angle at a corner as seen along N, and what the triangle says of the tangent there.
Vector3 weighted_tangent(const Mesh& mesh, int corner, const Vector3& n, const Vector3& along) {
  const int t = corner / 3, k = corner % 3;
  const Vector3& p = mesh.position(t, k);
  const Vector3 a = in_plane(mesh.position(t, (k + 1) % 3) - p, n);
  const Vector3 b = in_plane(mesh.position(t, (k + 2) % 3) - p, n);
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
  return angle * in_plane(along, n);
}

void complete_tangents(const Mesh& mesh, CornerFrames& frames) {
  const int count = 3 * mesh.triangle_count();
  std::vector<TextureAxes> axes(std::size_t(mesh.triangle_count()));
  parallel_for(mesh.triangle_count(),
               [&](std::int64_t t) { axes[std::size_t(t)] = texture_axes(mesh, int(t)); });
  const std::vector<int> numbers = numbered(mesh, frames.normals);
  Groups groups = groups_of(numbers, axes);

  std::vector<Vector3> sums(std::size_t(count), Vector3::Zero());
  for (int c = 0; c < count; ++c)
    if (axes[std::size_t(c / 3)].sign != 0)
      sums[std::size_t(groups.find(c))] +=
          weighted_tangent(mesh, c, frames.normals[std::size_t(c)].cast<double>(),
                           axes[std::size_t(c / 3)].along);
  std::vector<int> other(std::size_t(count), -1);  // per number a corner that has a tangent
  for (int c = count - 1; c >= 0; --c)
    if (axes[std::size_t(c / 3)].sign != 0) other[std::size_t(numbers[std::size_t(c)])] = c;
  for (int c = 0; c < count; ++c) {
    if (frames.tangents[std::size_t(c)][3] != 0) continue;
    const Vector3 n = frames.normals[std::size_t(c)].cast<double>();
    const int from =
        axes[std::size_t(c / 3)].sign != 0 ? c : other[std::size_t(numbers[std::size_t(c)])];
    Vector3 tangent = from < 0 ? Vector3(Vector3::Zero())
                               : in_plane(sums[std::size_t(groups.find(from))], n);
    if (tangent.isZero()) tangent = across(n);
    const int sign = from < 0 ? 1 : axes[std::size_t(from / 3)].sign;
    frames.tangents[std::size_t(c)] << tangent.cast<float>(), float(sign);
  }
}

}  // namespace

std::vector<Eigen::Vector3f> frame_normals(const Mesh& mesh, std::vector<Eigen::Vector3f> given) {
  const std::size_t count = 3 * std::size_t(mesh.triangle_count());
  require(given.empty() || given.size() == count,
          fmt::format("{} normals are given for {} corners of triangles", given.size(), count));
  complete_normals(mesh, given);
  return given;
}

CornerFrames tangent_frames(const Mesh& mesh, CornerFrames given) {
  const std::size_t count = 3 * std::size_t(mesh.triangle_count());
  require((given.normals.empty() || given.normals.size() == count) &&
              (given.tangents.empty() || given.tangents.size() == count),
          fmt::format("{} normals and {} tangents are given for {} corners of triangles",
                      given.normals.size(), given.tangents.size(), count));
  complete_normals(mesh, given.normals);
  bool all = !given.tangents.empty();
  given.tangents.resize(count, Eigen::Vector4f::Zero());
  for (std::size_t c = 0; c < count; ++c) {
    Eigen::Vector4f& tangent = given.tangents[c];
    const Vector3 along =
        in_plane(tangent.head<3>().cast<double>(), given.normals[c].cast<double>());
    const bool known = tangent.allFinite() && !along.isZero();
    tangent << along.cast<float>(), known ? (tangent[3] < 0 ? -1.0F : 1.0F) : 0.0F;
    all = all && known;
  }
  if (!all) complete_tangents(mesh, given);
  return given;
}

Vector3 TangentFrame::to_model(const Vector3& mapped) const {
  const Vector3 n = mapped.x() * tangent + mapped.y() * bitangent + mapped.z() * normal;
  const double length = n.norm();
  return length > 0 ? Vector3(n / length) : Vector3(normal.normalized());
}

Vector3 TangentFrame::to_map(const Vector3& n) const {
  // Rows of the inverse of (T B N), but for the determinant, of which only the sign counts.
  const Vector3 mapped(bitangent.cross(normal).dot(n), normal.cross(tangent).dot(n),
                       tangent.cross(bitangent).dot(n));
  const double length = mapped.norm();
  if (!(length > 0)) return Vector3::UnitZ();
  return mapped / (tangent.cross(bitangent).dot(normal) < 0 ? -length : length);
}

TangentFrame frame_at(const CornerFrames& frames, const SurfacePoint& point) {
  const std::size_t first = 3 * std::size_t(point.triangle);
  const auto normal = [&](int k) { return Vector3(frames.normals[first + k].cast<double>()); };
  Vector3 n = interpolate(point.barycentric, normal);
  constexpr double least = 1e-3;
  if (n.norm() < least) {
    int nearest = 0;
    point.barycentric.maxCoeff(&nearest);
    n = normal(nearest);
  }
  const Eigen::Vector4d t = interpolate(point.barycentric, [&](int k) {
    return Eigen::Vector4d(frames.tangents[first + k].cast<double>());
  });
  Vector3 tangent = t.head<3>();
  if (n.cross(tangent).norm() < least * n.norm()) tangent = across(n.normalized());
  return {tangent, (t[3] < 0 ? -1.0 : 1.0) * n.cross(tangent), n};
}

}  // namespace mq
