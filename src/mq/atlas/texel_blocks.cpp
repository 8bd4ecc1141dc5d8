// Blocks are the cells of an atlas that is shrunk by their side, so that triangles are cut to blocks by the same
// exact clipping that cuts them to texels.

#include "mq/atlas/texel_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mq/atlas/clip.h"
#include "mq/base/error.h"

namespace mq {
namespace {

constexpr int least_side = 8;

int wrapped_block(int at, int count, Wrap wrap) {
  if (wrap == Wrap::repeat) return ((at % count) + count) % count;
  return std::clamp(at, 0, count - 1);
}

}  // namespace

TexelBlocks::TexelBlocks(const Surface& surface, const Atlas& atlas, const Seams& seams, int side)
    : textures_(atlas.textures), side_(side), first_{0} {
  require(side >= least_side, fmt::format("blocks of {} texels a side: they must have {} or more", side, least_side));
  for (const TextureSize& size : textures_) {
    columns_.push_back((size.width + side - 1) / side);
    first_.push_back(first_.back() + columns_.back() * ((size.height + side - 1) / side));
  }
  graph_.weights.assign(std::size_t(count()), 0);
  graph_.edges.resize(std::size_t(count()));
  weigh(surface, atlas);
  join_beside();
  join_across(seams);
  for (auto& edges : graph_.edges)
    std::ranges::sort(edges, {}, &WeightedGraph::Edge::to);
}

int TexelBlocks::texture(int block) const {
  return int(std::ranges::upper_bound(first_, block) - first_.begin()) - 1;
}

TexelBlocks::Extent TexelBlocks::extent(int block) const {
  const int k = texture(block), local = block - first_[std::size_t(k)], columns = columns_[std::size_t(k)];
  const TextureSize& size = textures_[std::size_t(k)];
  const int x = local % columns * side_, y = local / columns * side_;
  return {k, x, y, std::min(x + side_, size.width), std::min(y + side_, size.height)};
}

/// The area of triangles in each block.
void TexelBlocks::weigh(const Surface& surface, const Atlas& atlas) {
  constexpr std::int64_t half = TexelPoint::one / 2;  // texel i lies at i; a block begins half a texel before its first
  const double texels = double(side_) * side_;
  for (int t = 0; t < int(atlas.chart.size()); ++t) {
    if (atlas.chart[std::size_t(t)] < 0) continue;
    const int k = surface.mesh.texture(t), columns = columns_[std::size_t(k)];
    const int rows = (first_[std::size_t(k) + 1] - first_[std::size_t(k)]) / columns;
    const Wrap wrap = textures_[std::size_t(k)].wrap;
    auto corners = atlas.corners[std::size_t(t)];
    for (TexelPoint& p : corners) p.x = (p.x + half) / side_, p.y = (p.y + half) / side_;
    if (orientation(corners[0], corners[1], corners[2]) == 0) continue;
    const auto add = [&](int row, int column, double area) {
      graph_.weights[std::size_t(first_[std::size_t(k)] + wrapped_block(row, rows, wrap) * columns +
                                 wrapped_block(column, columns, wrap))] += area * texels;
    };
    const auto [first, end] = rows_of(corners);
    for (int row = first; row < end; ++row)
      clip_row(
          corners, row, [&](const Piece& piece) { add(row, piece.column, piece.area()); },
          [&](int, int from, int to) {
            for (int column = from; column <= to; ++column) add(row, column, 1);
          });
  }
}

void TexelBlocks::join(int a, int b, double weight) {
  if (a == b || weight <= 0) return;
  for (const auto& [from, to] : {std::pair(a, b), {b, a}}) {
    auto& edges = graph_.edges[std::size_t(from)];
    const auto at = std::ranges::find(edges, to, &WeightedGraph::Edge::to);
    if (at == edges.end())
      edges.push_back({to, weight});
    else
      at->weight += weight;
  }
}

/// Blocks side by side, by how much of the poorer one charts cover.
void TexelBlocks::join_beside() {
  const double texels = double(side_) * side_;
  for (int k = 0; k < int(textures_.size()); ++k) {
    const int columns = columns_[std::size_t(k)];
    for (int b = first_[std::size_t(k)]; b < first_[std::size_t(k) + 1]; ++b)
      for (const auto& [other, exists] :
           {std::pair(b + 1, (b - first_[std::size_t(k)]) % columns + 1 < columns),
            {b + columns, b + columns < first_[std::size_t(k) + 1]}})
        if (exists) {
          const double covered =
              std::min({graph_.weights[std::size_t(b)], graph_.weights[std::size_t(other)], texels});
          join(b, other, side_ * covered / texels);
        }
  }
}

/// Blocks on both sides of a seam: once for each stretch between two texel lines.
void TexelBlocks::join_across(const Seams& seams) {
  for (int e = 0; e < seams.count(); ++e) {
    const auto breaks = seams.breaks(e);
    for (std::size_t i = 1; i < breaks.size(); ++i) {
      std::array<int, 2> sides{};
      for (int s = 0; s < 2; ++s) {
        const TexturePlace p =
            seams.place(seams.half_edges(e)[std::size_t(s)], (breaks[i - 1] + breaks[i]) / 2);
        const TextureSize& size = textures_[std::size_t(p.texture)];
        sides[std::size_t(s)] = block(p.texture, wrapped_block(p.column, size.width, size.wrap),
                                      wrapped_block(p.row, size.height, size.wrap));
      }
      join(sides[0], sides[1], 1);
    }
  }
}

int block_side(const Atlas& atlas, int parts) {
  constexpr double blocks_each = 64;
  int side = 512;
  while (side > 16 && double(side) * side * blocks_each * parts > atlas.texel_area) side /= 2;
  return side;
}

}  // namespace mq
