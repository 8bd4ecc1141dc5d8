#include "mq/video/texel_owners.h"

#include "mq/mesh/geometry.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace {

}  // namespace

Vector3 nearest_in_triangle(const std::array<Vector2, 3>& c, const Vector2& p) {
  const double twice = cross(c[1] - c[0], c[2] - c[0]);
  if (twice != 0) {
    Vector3 b;
    for (int k = 0; k < 3; ++k) b[k] = cross(c[(k + 1) % 3] - p, c[(k + 2) % 3] - p) / twice;
    if (b.minCoeff() >= 0) return b;
  }
  double least = std::numeric_limits<double>::infinity();
  Vector3 nearest = Vector3::UnitX();
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const Vector2 edge = c[l] - c[k];
    const double square = edge.squaredNorm();
    const double t = square > 0 ? std::clamp((p - c[k]).dot(edge) / square, 0.0, 1.0) : 0.0;
    const double distance = (c[k] + t * edge - p).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = Vector3::Zero();
    nearest[k] = 1 - t;
    nearest[l] = t;
  }
  return nearest;
}

TexelOwners::TexelOwners(const Mesh& mesh, int width, int height, int samples, double margin)
    : mesh_(mesh),
      width_(width),
      height_(height),
      samples_(samples),
      owners_(std::size_t(width) * height * samples * samples) {
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.textured(t)) add(t, margin);
}

std::array<Vector2, 3> TexelOwners::corners(int t) const {
  std::array<Vector2, 3> result;
  for (int k = 0; k < 3; ++k) {
    const Vector2& uv = mesh_.uv(t, k);
    result[k] = {uv.x() * width_, (1 - uv.y()) * height_};
  }
  return result;
}

void TexelOwners::add(int t, double margin) {
  const std::array<Vector2, 3> c = corners(t);
  const Vector2 low = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
  const auto first = [&](double x, int size) {
    return int(std::clamp(std::floor((x - margin) * samples_), 0.0, double(size) * samples_));
  };
  const auto last = [&](double x, int size) {
    return int(std::clamp(std::ceil((x + margin) * samples_), 0.0, double(size) * samples_));
  };
  for (int row = first(low.y(), height_); row < last(high.y(), height_); ++row)
    for (int column = first(low.x(), width_); column < last(high.x(), width_); ++column) {
      Owner& owner = owners_[std::size_t(row) * width_ * samples_ + column];
      if (owner.distance == 0) continue;
      const Vector2 p = place(column, row);
      const Vector3 b = nearest_in_triangle(c, p);
      const float distance = float((b[0] * c[0] + b[1] * c[1] + b[2] * c[2] - p).norm());
      if (distance > margin || distance >= owner.distance) continue;
      owner = {t, distance < 1e-9F ? 0 : distance};
    }
}

}  // namespace mq
