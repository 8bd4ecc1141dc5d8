#include "mq/draw/texel_maps.h"

#include <algorithm>
#include <array>
#include <span>

#include "mq/atlas/coverage.h"
#include "mq/atlas/texel_patches.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/texel_space.h"

namespace mq {
namespace {

std::array<float, 3> label_colour(int n) {
  constexpr std::uint32_t mask = (1U << 24) - 1, odd = 0x9E3779B1U;  // 2³² / golden ratio
  const std::uint32_t bits = n < 0 ? 0 : (std::uint32_t(n) + 1) * odd & mask;
  return {float(bits >> 16) / 255, float(bits >> 8 & 255) / 255, float(bits & 255) / 255};
}

TexelMaps black(const Atlas& atlas, int channels) {
  TexelMaps maps;
  for (const TextureSize& size : atlas.textures)
    maps.pictures.emplace_back(size.width, size.height, channels);
  return maps;
}

void mark(TexelMaps& maps, int texture, int x, int y, std::span<const float> values) {
  const auto pixel = maps.pictures[std::size_t(texture)].pixel(x, y);
  std::copy_n(values.begin(), pixel.size(), pixel.begin());
  ++maps.marked;
}

void mark(TexelMaps& maps, int texture, int x, int y, float value) {
  mark(maps, texture, x, y, {&value, 1});
}

/// Texels that charts read.
TexelMaps read_texels(const Surface& surface, const Atlas& atlas, TexelUse use,
                      const Progress& progress) {
  const TexelSpace space(surface, atlas, {}, progress);
  const Texels& texels = space.texels();
  TexelMaps maps = black(atlas, use == TexelUse::chart ? 3 : 1);
  maps.defects = space.defects();
  for (int i = 0; i < texels.size(); ++i) {
    const Texels::Place& at = texels.places[std::size_t(i)];
    if (use == TexelUse::boundary && texels.interior[std::size_t(i)]) continue;
    if (use == TexelUse::chart)
      mark(maps, at.texture, at.x, at.y, label_colour(texels.chart[std::size_t(i)]));
    else
      mark(maps, at.texture, at.x, at.y, 1);
  }
  return maps;
}

TexelMaps covered_texels(const Surface& surface, const Atlas& atlas, TexelUse use,
                         const Progress& progress) {
  const std::vector<Coverage> coverage = texel_coverage(surface, atlas, progress);
  TexelMaps maps = black(atlas, use == TexelUse::triangle ? 3 : 1);
  for (std::size_t k = 0; k < coverage.size(); ++k)
    for (int y = 0; y < coverage[k].count.height(); ++y)
      for (int x = 0; x < coverage[k].count.width(); ++x) {
        const int count = coverage[k].count(x, y);
        if (count == 0 || (use == TexelUse::overlap && count < 2)) continue;
        if (use == TexelUse::triangle)
          mark(maps, int(k), x, y, label_colour(coverage[k].triangle(x, y)));
        else if (use == TexelUse::overlap)
          mark(maps, int(k), x, y, 1);
        else
          mark(maps, int(k), x, y, float(std::min(count, 255)) / 255);
      }
  return maps;
}

/// Sets each of `count` values, `stride` apart, to 1 that is at most `reach` of them from one that is not 0.
void spread(float* values, int count, std::ptrdiff_t stride, int reach) {
  std::vector<int> marked;
  for (int i = 0; i < count; ++i)
    if (values[i * stride] != 0) marked.push_back(i);
  int next = 0;  // the first value not set yet
  for (const int at : marked)
    for (next = std::max(next, at - reach); next <= std::min(count - 1, at + reach); ++next)
      values[next * stride] = 1;
}

}  // namespace

std::vector<Defect::Place> marked_places(const TexelMaps& maps) {
  std::vector<TexelRun> runs;
  for (std::size_t k = 0; k < maps.pictures.size(); ++k) {
    const Image<float>& picture = maps.pictures[k];
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        if (std::ranges::all_of(picture.pixel(x, y), [](float value) { return value == 0; })) continue;
        if (!runs.empty() && runs.back().texture == int(k) && runs.back().row == y && runs.back().last == x - 1)
          runs.back().last = x;
        else
          runs.push_back({int(k), y, x, x});
      }
  }
  return texel_patches(runs);
}

void grow(TexelMaps& maps, int texels) {
  for (Image<float>& picture : maps.pictures) {
    require(picture.channels() == 1, "only marks in black and white can be grown");
    const int width = picture.width(), height = picture.height();
    parallel_for(height, [&](std::int64_t y) { spread(&picture(0, int(y)), width, 1, texels); });
    parallel_for(width, [&](std::int64_t x) { spread(&picture(int(x), 0), height, width, texels); });
  }
}

TexelMaps texel_maps(const Surface& surface, const Atlas& atlas, TexelUse use,
                     const Progress& progress) {
  const bool covered = use == TexelUse::triangle || use == TexelUse::overlap || use == TexelUse::depth;
  return covered ? covered_texels(surface, atlas, use, progress)
                 : read_texels(surface, atlas, use, progress);
}

}  // namespace mq
