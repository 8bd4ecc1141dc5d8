// A triangle is in all buckets that its box meets, so that the one of a place has all that cover it.
#include "mq/atlas/triangles_at.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace {

struct Extent {
  double left = 0, top = 0, right = 0, bottom = 0;
};

Extent extent_of(const std::array<TexelPoint, 3>& corners) {
  const auto [a, b, c] = corners;
  return {std::min({a.column(), b.column(), c.column()}), std::min({a.row(), b.row(), c.row()}),
          std::max({a.column(), b.column(), c.column()}), std::max({a.row(), b.row(), c.row()})};
}

int bucket_of(double coordinate, double start, double side, int count) {
  return int(std::clamp(std::floor((coordinate - start) / side), 0.0, double(count - 1)));
}

}  // namespace

TrianglesAt::TrianglesAt(const Mesh& mesh, const Atlas& atlas)
    : atlas_(atlas), textures_(atlas.textures.size()) {
  std::vector<std::vector<int>> own(textures_.size());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (atlas.chart[std::size_t(t)] >= 0) own[std::size_t(mesh.texture(t))].push_back(t);
  for (std::size_t k = 0; k < own.size(); ++k) {
    Buckets& buckets = textures_[k];
    Extent all;
    for (std::size_t i = 0; i < own[k].size(); ++i) {
      const Extent box = extent_of(atlas.corners[std::size_t(own[k][i])]);
      if (i == 0) all = box;
      all = {std::min(all.left, box.left), std::min(all.top, box.top),
             std::max(all.right, box.right), std::max(all.bottom, box.bottom)};
    }
    // As many buckets as triangles.
    const double width = all.right - all.left, height = all.bottom - all.top;
    const double count = double(std::max<std::size_t>(1, own[k].size()));
    buckets.left = all.left, buckets.top = all.top;
    buckets.side = std::max({std::sqrt(width * height / count), width / count, height / count, 1e-9});
    buckets.columns = int(width / buckets.side) + 1;
    buckets.rows = int(height / buckets.side) + 1;
    const auto each = [&](const auto& visit) {
      for (const int t : own[k]) {
        const Extent box = extent_of(atlas.corners[std::size_t(t)]);
        const int last_row = bucket_of(box.bottom, all.top, buckets.side, buckets.rows);
        const int last_column = bucket_of(box.right, all.left, buckets.side, buckets.columns);
        for (int j = bucket_of(box.top, all.top, buckets.side, buckets.rows); j <= last_row; ++j)
          for (int i = bucket_of(box.left, all.left, buckets.side, buckets.columns);
               i <= last_column; ++i)
            visit(std::size_t(j) * buckets.columns + i, t);
      }
    };
    buckets.first.assign(std::size_t(buckets.columns) * buckets.rows + 1, 0);
    each([&](std::size_t bucket, int) { ++buckets.first[bucket + 1]; });
    for (std::size_t b = 1; b < buckets.first.size(); ++b) buckets.first[b] += buckets.first[b - 1];
    buckets.triangles.resize(std::size_t(buckets.first.back()));
    std::vector<int> next(buckets.first.begin(), buckets.first.end() - 1);
    each([&](std::size_t bucket, int t) { buckets.triangles[std::size_t(next[bucket]++)] = t; });
  }
}

TrianglesAt::Found TrianglesAt::operator()(int texture, const TexelPoint& place) const {
  const Buckets& buckets = textures_[std::size_t(texture)];
  if (buckets.triangles.empty()) return {};
  const std::size_t bucket =
      std::size_t(bucket_of(place.row(), buckets.top, buckets.side, buckets.rows)) *
          buckets.columns +
      bucket_of(place.column(), buckets.left, buckets.side, buckets.columns);
  for (int i = buckets.first[bucket]; i < buckets.first[bucket + 1]; ++i) {
    const int t = buckets.triangles[std::size_t(i)];
    const auto& [a, b, c] = atlas_.corners[std::size_t(t)];
    if (std::min({a.x, b.x, c.x}) > place.x || std::max({a.x, b.x, c.x}) < place.x ||
        std::min({a.y, b.y, c.y}) > place.y || std::max({a.y, b.y, c.y}) < place.y)
      continue;
    const Int128 area = orientation(a, b, c),
                 parts[] = {orientation(b, c, place), orientation(c, a, place),
                            orientation(a, b, place)};
    if (area == 0) continue;
    const auto outside = [&](const Int128& part) { return sign(part) * sign(area) < 0; };
    if (outside(parts[0]) || outside(parts[1]) || outside(parts[2])) continue;
    Found found{t};
    for (int k = 0; k < 3; ++k) found.barycentric[k] = double(parts[k]) / double(area);
    return found;
  }
  return {};
}

}  // namespace mq
