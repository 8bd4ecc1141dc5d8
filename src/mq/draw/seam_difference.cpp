#include "mq/draw/seam_difference.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "mq/base/parallel.h"
#include "mq/draw/textures.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

struct Lookup {
  const Surface& surface;
  const Atlas& atlas;
  const std::vector<const Image<float>*>& textures;

  int texture(HalfEdge h) const { return surface.mesh.texture(h / 3); }
  int channels(HalfEdge h) const { return colour_channels(textures[texture(h)]->channels()); }

  /// Values at the fraction `s` along a half-edge, seen from its own triangle.
  void at(HalfEdge h, double s, std::span<float> values) const {
    const TexelPoint& a = atlas.corners[h / 3][h % 3];
    const TexelPoint& b = atlas.corners[h / 3][(h % 3 + 1) % 3];
    sample(*textures[texture(h)], a.column() + s * (b.column() - a.column()),
           a.row() + s * (b.row() - a.row()), atlas.textures[texture(h)].wrap, values);
  }

  double texels(HalfEdge h) const {
    const TexelPoint& a = atlas.corners[h / 3][h % 3];
    const TexelPoint& b = atlas.corners[h / 3][(h % 3 + 1) % 3];
    return std::hypot(a.column() - b.column(), a.row() - b.row());
  }
};

/// What is known of some seam edges; parts are joined in order.
struct Part {
  double square = 0, length = 0;
  std::vector<float> differences;
  HalfEdge edge = -1;
  double fraction = 0, largest = -1;

  Part operator+(const Part& later) const {
    Part sum = later.largest > largest ? later : *this;
    sum.square = square + later.square;
    sum.length = length + later.length;
    sum.differences = differences;
    sum.differences.insert(sum.differences.end(), later.differences.begin(), later.differences.end());
    return sum;
  }
};

void add_edge(const Lookup& lookup, HalfEdge h, Part& part) {
  const Mesh& mesh = lookup.surface.mesh;
  const HalfEdge twin = lookup.surface.twins[h];
  const int channels = std::min({lookup.channels(h), lookup.channels(twin)});
  std::vector<float> here(channels), there(channels);
  const double length = (mesh.position(h / 3, (h % 3 + 1) % 3) - mesh.position(h / 3, h % 3)).norm();
  const double texels = std::max(lookup.texels(h), lookup.texels(twin));
  const int count = int(std::clamp(std::ceil(2 * texels), 1.0, 4096.0));
  for (int i = 0; i < count; ++i) {
    const double s = (i + 0.5) / count;
    lookup.at(h, s, here);
    lookup.at(twin, 1 - s, there);
    double square = 0;
    for (int k = 0; k < channels; ++k) square += std::pow(double(here[k]) - there[k], 2) / channels;
    part.square += square * length / count;
    part.differences.push_back(float(std::sqrt(square)));
    if (std::sqrt(square) > part.largest) {
      part.largest = std::sqrt(square);
      part.edge = h, part.fraction = s;
    }
  }
  part.length += length;
}

SeamPlace place_of(const Lookup& lookup, const Part& part) {
  SeamPlace place;
  if (part.edge < 0) return place;
  const Mesh& mesh = lookup.surface.mesh;
  const HalfEdge h = part.edge, twin = lookup.surface.twins[h];
  place.edge = h;
  place.fraction = part.fraction;
  place.difference = part.largest;
  place.point = (1 - part.fraction) * mesh.position(h / 3, h % 3) +
                part.fraction * mesh.position(h / 3, (h % 3 + 1) % 3);
  const Vector3 normal = triangle_normal(mesh, h / 3);
  const Vector3 sum = normal + triangle_normal(mesh, twin / 3);
  place.normal = sum.norm() > 1e-6 ? Vector3(sum.normalized()) : normal;
  place.here.resize(lookup.channels(h));
  place.there.resize(lookup.channels(twin));
  lookup.at(h, part.fraction, place.here);
  lookup.at(twin, 1 - part.fraction, place.there);
  return place;
}

}  // namespace

SeamDifference seam_difference(const Surface& surface, const Atlas& atlas,
                               const std::vector<const Image<float>*>& textures) {
  check_textures(atlas, textures);
  const Lookup lookup{surface, atlas, textures};
  Part sum = parallel_sum(std::int64_t(atlas.edges.size()), Part(),
                          [&](std::int64_t begin, std::int64_t end) {
    Part part;
    for (HalfEdge h = HalfEdge(begin); h < HalfEdge(end); ++h)
      if (atlas.chart[h / 3] >= 0 && atlas.edges[h] == EdgeKind::seam && h < surface.twins[h])
        add_edge(lookup, h, part);
    return part;
  });
  SeamDifference result;
  result.length = sum.length;
  result.places = std::int64_t(sum.differences.size());
  result.worst = place_of(lookup, sum);
  if (sum.length > 0) result.rms = std::sqrt(sum.square / sum.length);
  if (!sum.differences.empty()) {
    const auto at = sum.differences.begin() + std::ptrdiff_t(sum.differences.size() * 99 / 100);
    std::nth_element(sum.differences.begin(), at, sum.differences.end());
    result.difference_p99 = *at;
  }
  return result;
}

}  // namespace mq
