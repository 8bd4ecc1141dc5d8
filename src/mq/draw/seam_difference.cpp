#include "mq/draw/seam_difference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/draw/detail/textures.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

struct Lookup {
  const Surface& surface;
  const Atlas& atlas;
  const std::vector<const Image<float>*>& textures;
  const SeenValue& seen;

  int texture(HalfEdge h) const { return surface.mesh.texture(h / 3); }
  int channels(HalfEdge h) const { return colour_channels(textures[texture(h)]->channels()); }

  /// Values at the fraction `s` along a half-edge, seen from its own triangle.
  void at(HalfEdge h, double s, std::span<float> values) const {
    const TexelPoint& a = atlas.corners[h / 3][h % 3];
    const TexelPoint& b = atlas.corners[h / 3][(h % 3 + 1) % 3];
    sample(*textures[texture(h)], a.column() + s * (b.column() - a.column()),
           a.row() + s * (b.row() - a.row()), atlas.textures[texture(h)].wrap, values);
    if (!seen) return;
    SurfacePoint point{h / 3, Vector3::Zero()};
    point.barycentric[h % 3] = 1 - s;
    point.barycentric[(h % 3 + 1) % 3] = s;
    seen(point, values);
  }

  /// Texels of the smaller of the two charts.
  double smaller_chart(HalfEdge h, HalfEdge twin) const {
    return std::min(atlas.charts[atlas.chart[h / 3]].texel_area, atlas.charts[atlas.chart[twin / 3]].texel_area);
  }

  double texels(HalfEdge h) const {
    const TexelPoint& a = atlas.corners[h / 3][h % 3];
    const TexelPoint& b = atlas.corners[h / 3][(h % 3 + 1) % 3];
    return std::hypot(a.column() - b.column(), a.row() - b.row());
  }
};

/// What is known of one seam edge.
struct EdgeDifference {
  HalfEdge edge;
  double fraction, largest;  ///< of the largest difference
  double weight, center;     ///< ∫ difference², and its centre as a fraction
  double shown;              ///< as `SeamPlace::shown`
};

/// The same of some edges; parts are joined in order.
struct Part {
  double length = 0;
  std::vector<float> differences;
  std::vector<EdgeDifference> edges;

  Part operator+(const Part& later) const {
    Part sum = *this;
    sum.length += later.length;
    sum.differences.insert(sum.differences.end(), later.differences.begin(),
                           later.differences.end());
    sum.edges.insert(sum.edges.end(), later.edges.begin(), later.edges.end());
    return sum;
  }
};

/// Root mean square over the channels both have.
double difference(const std::vector<float>& a, const std::vector<float>& b) {
  const std::size_t channels = std::min(a.size(), b.size());
  double square = 0;
  for (std::size_t k = 0; k < channels; ++k)
    square += (double(a[k]) - b[k]) * (double(a[k]) - b[k]);
  return std::sqrt(square / double(channels));
}

void add_edge(const Lookup& lookup, HalfEdge h, Part& part) {
  const Mesh& mesh = lookup.surface.mesh;
  const HalfEdge twin = lookup.surface.twins[h];
  const int channels = std::min(lookup.channels(h), lookup.channels(twin));
  std::vector<float> here(channels), there(channels);
  const double length =
      (mesh.position(h / 3, (h % 3 + 1) % 3) - mesh.position(h / 3, h % 3)).norm();
  const double texels = std::max(lookup.texels(h), lookup.texels(twin));
  const int count = int(std::clamp(std::ceil(2 * texels), 1.0, 4096.0));
  EdgeDifference edge{h, 0.5, -1, 0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const double s = (i + 0.5) / count;
    lookup.at(h, s, here);
    lookup.at(twin, 1 - s, there);
    const double jump = difference(here, there), square = jump * jump;
    edge.weight += square * length / count;
    edge.center += s * square * length / count;
    edge.shown += std::min(square, SeamPlace::clear * SeamPlace::clear) * length / count;
    part.differences.push_back(float(jump));
    if (jump > edge.largest) edge.largest = jump, edge.fraction = s;
  }
  const double facing = triangle_normal(mesh, h / 3).dot(triangle_normal(mesh, twin / 3));
  edge.shown *= std::max(0.05, facing) * std::min(1.0, lookup.smaller_chart(h, twin) / SeamPlace::enough_texels);
  edge.center = edge.weight > 0 ? edge.center / edge.weight : 0.5;
  part.length += length;
  part.edges.push_back(edge);
}

SeamPlace place_of(const Lookup& lookup, const EdgeDifference& edge, double fraction) {
  const Mesh& mesh = lookup.surface.mesh;
  const HalfEdge h = edge.edge, twin = lookup.surface.twins[h];
  SeamPlace place;
  place.edge = h;
  place.fraction = fraction;
  place.weight = edge.weight;
  place.shown = edge.shown;
  place.point = (1 - fraction) * mesh.position(h / 3, h % 3) +
                fraction * mesh.position(h / 3, (h % 3 + 1) % 3);
  const Vector3 normal = triangle_normal(mesh, h / 3);
  const Vector3 sum = normal + triangle_normal(mesh, twin / 3);
  place.normal = sum.norm() > 1e-6 ? Vector3(sum.normalized()) : normal;
  place.here.resize(lookup.channels(h));
  place.there.resize(lookup.channels(twin));
  lookup.at(h, fraction, place.here);
  lookup.at(twin, 1 - fraction, place.there);
  place.difference = difference(place.here, place.there);
  return place;
}

constexpr std::size_t most_edges = 1000;

}  // namespace

SeamDifference seam_difference(const Surface& surface, const Atlas& atlas,
                               const std::vector<const Image<float>*>& textures,
                               const SeenValue& seen) {
  check_textures(atlas, textures);
  const Lookup lookup{surface, atlas, textures, seen};
  Part sum = parallel_sum(
      std::int64_t(atlas.edges.size()), Part(), [&](std::int64_t begin, std::int64_t end) {
        Part part;
        for (HalfEdge h = HalfEdge(begin); h < HalfEdge(end); ++h)
          if (atlas.chart[h / 3] >= 0 && atlas.edges[h] == EdgeKind::seam && h < surface.twins[h])
            add_edge(lookup, h, part);
        return part;
      });
  SeamDifference result;
  result.length = sum.length;
  result.places = std::int64_t(sum.differences.size());
  if (!sum.edges.empty()) {
    const EdgeDifference& worst = *std::ranges::max_element(sum.edges, {}, &EdgeDifference::largest);
    result.worst = place_of(lookup, worst, worst.fraction);
  }
  double square = 0;
  for (const EdgeDifference& edge : sum.edges) square += edge.weight;
  if (sum.length > 0) result.rms = std::sqrt(square / sum.length);
  std::ranges::stable_sort(sum.edges, std::ranges::greater(), &EdgeDifference::shown);
  for (std::size_t i = 0; i < std::min(most_edges, sum.edges.size()); ++i)
    result.edges.push_back(place_of(lookup, sum.edges[i], sum.edges[i].center));
  if (!sum.differences.empty()) {
    const auto at = sum.differences.begin() + std::ptrdiff_t(sum.differences.size() * 99 / 100);
    std::nth_element(sum.differences.begin(), at, sum.differences.end());
    result.difference_p99 = *at;
  }
  return result;
}

}  // namespace mq
