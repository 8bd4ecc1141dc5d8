#include "mq/atlas/coverage.h"

#include <algorithm>
#include <array>

#include "mq/atlas/detail/coverage_of_texture.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

/// Whether the centre p is inside of the edge a → b of a triangle that lies to its left, where of
/// two triangles at an edge exactly one has the points on it.
bool inside(const TexelPoint& a, const TexelPoint& b, const TexelPoint& p) {
  const int side = sign(orientation(a, b, p));
  return side > 0 || (side == 0 && (b.y > a.y || (b.y == a.y && b.x < a.x)));
}

/// visit(column, row) for the centres that a triangle covers, before any wrapping.
template <class Visit>
void for_each_centre(std::array<TexelPoint, 3> p, const Visit& visit) {
  const int turn = sign(orientation(p[0], p[1], p[2]));
  if (turn == 0) return;
  if (turn < 0) std::swap(p[1], p[2]);
  const auto [left, right] = std::minmax({p[0].x, p[1].x, p[2].x});
  const auto [top, bottom] = std::minmax({p[0].y, p[1].y, p[2].y});
  for (int row = floor_texel(top - 1) + 1; row <= floor_texel(bottom); ++row)
    for (int column = floor_texel(left - 1) + 1; column <= floor_texel(right); ++column) {
      const TexelPoint centre{column * TexelPoint::one, row * TexelPoint::one};
      if (inside(p[0], p[1], centre) && inside(p[1], p[2], centre) && inside(p[2], p[0], centre))
        visit(column, row);
    }
}

Coverage nothing_covered(const TextureSize& size) {
  return {Image<int>(size.width, size.height, 1, -1), Image<int>(size.width, size.height, 1)};
}

void cover(const Atlas& atlas, int triangle, const TextureSize& size, Coverage& coverage) {
  for_each_centre(atlas.corners[triangle], [&](int column, int row) {
    const bool repeats = size.wrap == Wrap::repeat;
    if (!repeats && (column < 0 || row < 0 || column >= size.width || row >= size.height)) return;
    const int x = wrapped(column, size.width, size.wrap), y = wrapped(row, size.height, size.wrap);
    if (coverage.triangle(x, y) < 0) coverage.triangle(x, y) = triangle;
    ++coverage.count(x, y);
  });
}

}  // namespace

std::vector<Coverage> texel_coverage(const Surface& surface, const Atlas& atlas,
                                     const Progress& progress) {
  std::vector<Coverage> all;
  for (const TextureSize& size : atlas.textures) all.push_back(nothing_covered(size));
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (atlas.chart[t] < 0) continue;
    if (t % 1024 == 0) progress.at(double(t) / surface.triangle_count());
    const int texture = surface.mesh.texture(t);
    cover(atlas, t, atlas.textures[texture], all[texture]);
  }
  return all;
}

Coverage coverage_of_texture(const Surface& surface, const Atlas& atlas, int texture) {
  const TextureSize& size = atlas.textures[texture];
  Coverage coverage = nothing_covered(size);
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (atlas.chart[t] >= 0 && surface.mesh.texture(t) == texture) cover(atlas, t, size, coverage);
  return coverage;
}

std::int64_t overlapping_texels(std::span<const Coverage> coverage) {
  std::int64_t overlapping = 0;
  for (const Coverage& texture : coverage)
    overlapping += std::ranges::count_if(texture.count.values(), [](int n) { return n > 1; });
  return overlapping;
}

}  // namespace mq
