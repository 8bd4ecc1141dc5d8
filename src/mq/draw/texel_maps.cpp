#include "mq/draw/texel_maps.h"

#include <algorithm>
#include <array>
#include <span>

#include "mq/atlas/coverage.h"
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
        if (count == 0) continue;
        if (use == TexelUse::triangle)
          mark(maps, int(k), x, y, label_colour(coverage[k].triangle(x, y)));
        else
          mark(maps, int(k), x, y, float(std::min(count, 255)) / 255);
      }
  return maps;
}

}  // namespace

TexelMaps texel_maps(const Surface& surface, const Atlas& atlas, TexelUse use,
                     const Progress& progress) {
  const bool covered = use == TexelUse::triangle || use == TexelUse::overlap;
  return covered ? covered_texels(surface, atlas, use, progress)
                 : read_texels(surface, atlas, use, progress);
}

}  // namespace mq
