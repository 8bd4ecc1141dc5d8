// With u along a seam and n in the plane of a triangle across it, a way ⟨w, u⟩ u + ⟨w, n⟩ n of one side is one with the
// same two numbers of the other.
#include "mq/trace/atlas_walk.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr int most_crossed = 4096;

/// A triangle's edges from a corner, in its texture and in space.
struct Sides {
  Eigen::Matrix2d texture;
  Eigen::Matrix<double, 3, 2> space;
};

/// In the plane of both sides, at right angles to `along`, towards the second side.
Vector3 inward(const Vector3& along, const Vector3& other) {
  return (other - other.dot(along) * along).stableNormalized();
}

}  // namespace

Vector2 AtlasWalk::corner(HalfEdge h) const {
  const TexelPoint& p = atlas_.corners[std::size_t(h / 3)][std::size_t(h % 3)];
  return {p.column(), p.row()};
}

/// The half-edge through which a way leaves a triangle, having come in through `entry` (−1: begun in it); `at` moves
/// there, and `way` becomes what is left. None: it ends here.
std::optional<HalfEdge> AtlasWalk::leave(int triangle, HalfEdge entry, Vector2& at, Vector2& way) const {
  const HalfEdge first = 3 * triangle;
  const double turn = cross(corner(first + 1) - corner(first), corner(first + 2) - corner(first)) < 0 ? -1 : 1;
  std::optional<HalfEdge> found;
  double nearest = 1;
  for (HalfEdge h = first; h < first + 3; ++h) {
    if (h == entry) continue;
    const Vector2 a = corner(h), edge = corner(next(h)) - a;
    const double out = -turn * cross(edge, way);
    if (!(out > 0)) continue;
    const double part = std::max(0.0, turn * cross(edge, Vector2(at - a)) / out);
    if (part >= nearest) continue;
    nearest = part;
    found = h;
  }
  at += nearest * way;
  way *= 1 - nearest;
  return found;
}

void AtlasWalk::cross_seam(HalfEdge from, HalfEdge to, Vector2& at, Vector2& way) const {
  const auto sides = [&](HalfEdge h) {
    const int t = h / 3;
    const auto place = [&](HalfEdge e) { return surface_.mesh.position(t, e % 3); };
    Sides s;
    s.texture << corner(next(h)) - corner(h), corner(previous(h)) - corner(h);
    s.space << place(next(h)) - place(h), place(previous(h)) - place(h);
    return s;
  };
  const Sides here = sides(from), there = sides(to);
  const Vector3 along = here.space.col(0).stableNormalized();
  const Vector3 w = here.space * (here.texture.inverse() * way);
  const Vector3 carried = w.dot(along) * along - w.dot(inward(along, here.space.col(1))) *
                                                     inward(along, there.space.col(1));
  const double part = (at - corner(from)).dot(here.texture.col(0)) / here.texture.col(0).squaredNorm();
  const Eigen::Matrix2d gram = there.space.transpose() * there.space;
  way = there.texture * (gram.inverse() * (there.space.transpose() * carried));
  at = corner(next(to)) - std::clamp(part, 0.0, 1.0) * there.texture.col(0);
}

std::optional<AtlasPlace> AtlasWalk::operator()(const AtlasPlace& from, const Vector2& way) const {
  Vector2 at = from.texel, left = way;
  int triangle = from.triangle;
  HalfEdge entry = -1;
  for (int k = 0; k < most_crossed; ++k) {
    const std::optional<HalfEdge> exit = leave(triangle, entry, at, left);
    if (!exit) return AtlasPlace{triangle, at};
    entry = surface_.twins[std::size_t(*exit)];
    if (atlas_.edges[std::size_t(*exit)] == EdgeKind::boundary || entry < 0 ||
        atlas_.chart[std::size_t(entry / 3)] < 0)
      return {};
    triangle = entry / 3;
    if (atlas_.edges[std::size_t(*exit)] == EdgeKind::seam) cross_seam(*exit, entry, at, left);
    if (!at.allFinite() || !left.allFinite()) return {};
  }
  return {};
}

}  // namespace mq
