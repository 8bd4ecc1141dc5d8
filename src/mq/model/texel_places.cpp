// Centres that one triangle covers are looked up in the coverage. For the others, outside charts or in
// several of them, every triangle offers itself to the texels that its lookups read, and the nearest is
// taken.
#include "mq/model/detail/texel_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "mq/atlas/footprint.h"
#include "mq/base/parallel.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// A triangle in its texture, in texels.
class FlatCorners {
 public:
  FlatCorners(const Atlas& atlas, int triangle) {
    for (int k = 0; k < 3; ++k) {
      const TexelPoint& p = atlas.corners[std::size_t(triangle)][std::size_t(k)];
      corners_[k] = {p.column(), p.row()};
    }
  }

  Vector2 middle() const { return (corners_[0] + corners_[1] + corners_[2]) / 3; }

  /// Weights of the corners at a place in the plane.
  Vector3 weights(const Vector2& p) const {
    const Vector2 a = corners_[1] - corners_[0], b = corners_[2] - corners_[0];
    const Vector2 q = p - corners_[0];
    const double area = cross(a, b), second = cross(q, b) / area, third = cross(a, q) / area;
    return {1 - second - third, second, third};
  }

  /// The nearest point of the triangle.
  struct Nearest {
    double distance;
    Vector3 weights;
  };
  Nearest nearest(const Vector2& p) const {
    const Vector3 inside = weights(p);
    if (inside.minCoeff() >= 0) return {0, inside};
    Nearest best{std::numeric_limits<double>::infinity(), Vector3::Unit(0)};
    for (int k = 0; k < 3; ++k) {
      const Vector2 a = corners_[k], edge = corners_[(k + 1) % 3] - a;
      const double s = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const double distance = (a + s * edge - p).norm();
      if (!(distance < best.distance)) continue;
      best = {distance, Vector3::Zero()};
      best.weights[k] = 1 - s, best.weights[(k + 1) % 3] = s;
    }
    return best;
  }

 private:
  Vector2 corners_[3];
};

/// A place of the texture as it is stored, moved by whole textures to where the triangle is.
Vector2 moved_to(const FlatCorners& corners, const Vector2& p, const TextureSize& size) {
  if (size.wrap != Wrap::repeat) return p;
  const Vector2 away = corners.middle() - p;
  return p + Vector2(std::round(away.x() / size.width) * size.width,
                     std::round(away.y() / size.height) * size.height);
}

TexelPlace place_at(int triangle, const Vector3& weights) {
  return {triangle, float(weights[1]), float(weights[2])};
}

/// The map continued, unless that leads too far.
TexelPlace continued(int triangle, const Vector3& weights, const Vector3& nearest) {
  constexpr double reach = 2;
  const bool near = weights.allFinite() && weights.minCoeff() > -reach;
  return place_at(triangle, near ? weights : nearest);
}

/// What triangles offer to the texels that are not known yet.
class Offers {
 public:
  Offers(const Surface& surface, const Atlas& atlas, const Texels& texels,
         std::vector<TexelPlace>& places)
      : surface_(surface), atlas_(atlas), texels_(texels), places_(places) {
    for (const TextureSize& size : atlas.textures) numbers_.emplace_back(size.width, size.height, 1, -1);
    for (int i = 0; i < texels.size(); ++i) {
      if (places[std::size_t(i)].triangle >= 0) continue;
      const Texels::Place& at = texels.places[std::size_t(i)];
      numbers_[std::size_t(at.texture)](at.x, at.y) = int(open_.size());
      open_.push_back({i});
    }
  }

  void take_nearest() {
    if (open_.empty()) return;
    const Footprints footprints(atlas_);
    for (int t = 0; t < surface_.triangle_count(); ++t)
      if (atlas_.chart[std::size_t(t)] >= 0) offer(t, footprints.of(t));
    for (const Open& texel : open_)
      if (texel.triangle >= 0) places_[std::size_t(texel.unknown)] = texel.place;
  }

 private:
  struct Open {
    int unknown;
    int triangle = -1;
    double distance = 0;
    bool elsewhere = false;  ///< not of the texel's chart
    TexelPlace place = {};
  };

  void offer(int t, std::span<const TexelSpan> spans) {
    const int texture = surface_.mesh.texture(t);
    const Image<int>& numbers = numbers_[std::size_t(texture)];
    const Wrap wrap = atlas_.textures[std::size_t(texture)].wrap;
    const FlatCorners corners(atlas_, t);
    for (const TexelSpan& span : spans)
      for (int x = span.first; x < span.end; ++x) {
        const int number = numbers(wrapped(x, numbers.width(), wrap),
                                   wrapped(span.row, numbers.height(), wrap));
        if (number >= 0) offer(t, corners, Vector2(x, span.row), open_[std::size_t(number)]);
      }
  }

  void offer(int t, const FlatCorners& corners, const Vector2& p, Open& texel) const {
    const FlatCorners::Nearest found = corners.nearest(p);
    const bool elsewhere =
        atlas_.chart[std::size_t(t)] != texels_.chart[std::size_t(texel.unknown)];
    if (texel.triangle >= 0 && std::tie(texel.distance, texel.elsewhere) <=
                                   std::tie(found.distance, elsewhere))
      return;
    texel.triangle = t;
    texel.distance = found.distance;
    texel.elsewhere = elsewhere;
    texel.place = continued(t, corners.weights(p), found.weights);
  }

  const Surface& surface_;
  const Atlas& atlas_;
  const Texels& texels_;
  std::vector<TexelPlace>& places_;
  std::vector<Image<int>> numbers_;  ///< per texel its place in `open_`
  std::vector<Open> open_;
};

/// Texels that only a seam couples in: the triangle of a texel beside them.
void take_from_neighbours(const Atlas& atlas, const Texels& texels,
                          std::vector<TexelPlace>& places) {
  const std::vector<TexelPlace> known = places;
  constexpr int reach = 3;  // texels
  for (int i = 0; i < texels.size(); ++i) {
    if (places[std::size_t(i)].triangle >= 0) continue;
    const Texels::Place& at = texels.places[std::size_t(i)];
    int nearest = std::numeric_limits<int>::max(), from = -1;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const int k = texels.find({at.texture, at.x + dx, at.y + dy});
        if (k < 0 || known[std::size_t(k)].triangle < 0 || dx * dx + dy * dy >= nearest) continue;
        nearest = dx * dx + dy * dy;
        from = known[std::size_t(k)].triangle;
      }
    if (from < 0) continue;
    const FlatCorners corners(atlas, from);
    const Vector2 p =
        moved_to(corners, Vector2(at.x, at.y), atlas.textures[std::size_t(at.texture)]);
    places[std::size_t(i)] = continued(from, corners.weights(p), corners.nearest(p).weights);
  }
}

}  // namespace

std::vector<TexelPlace> texel_places(const Surface& surface, const Atlas& atlas,
                                     const Texels& texels,
                                     const std::vector<Coverage>& coverage) {
  std::vector<TexelPlace> places(std::size_t(texels.size()));
  parallel_for(texels.size(), [&](std::int64_t i) {
    const Texels::Place& at = texels.places[std::size_t(i)];
    const Coverage& covers = coverage[std::size_t(at.texture)];
    if (covers.count(at.x, at.y) != 1) return;
    const int t = covers.triangle(at.x, at.y);
    const FlatCorners corners(atlas, t);
    const Vector2 p =
        moved_to(corners, Vector2(at.x, at.y), atlas.textures[std::size_t(at.texture)]);
    places[std::size_t(i)] = place_at(t, corners.weights(p));
  });
  Offers(surface, atlas, texels, places).take_nearest();
  take_from_neighbours(atlas, texels, places);
  return places;
}

}  // namespace mq
