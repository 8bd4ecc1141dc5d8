#include "mq/atlas/overlap_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/atlas/coverage.h"

namespace mq {
namespace {

/// The atlas in textures of a `times`-th of the side, as far as `texel_coverage` asks.
Atlas reduced(const Atlas& atlas, int times) {
  Atlas small;
  small.chart = atlas.chart;
  small.corners = atlas.corners;
  for (TextureSize size : atlas.textures) {
    size.width = std::max(1, size.width / times), size.height = std::max(1, size.height / times);
    small.textures.push_back(size);
  }
  constexpr std::int64_t half = TexelPoint::one / 2;  // centres lie at whole texels, corners of pictures between them
  for (auto& corners : small.corners)
    for (TexelPoint& p : corners) p.x = (p.x + half) / times - half, p.y = (p.y + half) / times - half;
  return small;
}

double texel_count(const Atlas& atlas) {
  double count = 0;
  for (const TextureSize& size : atlas.textures) count += double(size.width) * size.height;
  return count;
}

}  // namespace

OverlapDepth overlap_depth(const Surface& surface, const Atlas& atlas, const Progress& progress) {
  constexpr double most = 1 << 22;
  const int times = std::max(1, int(std::ceil(std::sqrt(atlas.texel_area / most))));
  const std::vector<Coverage> coverage =
      times > 1 ? texel_coverage(surface, reduced(atlas, times), progress) : texel_coverage(surface, atlas, progress);
  double used = 0, all = 0;
  for (const Coverage& texture : coverage)
    for (const int count : texture.count.values()) used += count > 0, all += count;
  if (used == 0) return {};
  return {.share = double(overlapping_texels(coverage)) / used, .mean = all / used};
}

Defects deep_overlaps(const Surface& surface, const Atlas& atlas, const Progress& progress) {
  constexpr double deep = 64, most = 1 << 28;
  if (atlas.texel_area < most || atlas.texel_area < deep * texel_count(atlas)) return {};
  const OverlapDepth found = overlap_depth(surface, atlas, progress);
  std::vector<std::int64_t> triangles;
  for (std::size_t t = 0; t < atlas.chart.size(); ++t)
    if (atlas.chart[t] >= 0) triangles.push_back(std::int64_t(t));
  Defects defects;
  add_defect(defects, "deep_overlaps", Defect::Severity::refused, "triangle", triangles,
             fmt::format("triangles that lie {:.0f} deep on each other in their texture; {:.0f} % of the texels in use "
                         "are covered more than once: unwrap them apart, or use a smaller texture",
                         found.mean, 100 * found.share));
  return defects;
}

}  // namespace mq
