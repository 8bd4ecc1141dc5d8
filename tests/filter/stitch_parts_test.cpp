// What regions ask for where they meet, worked out for a part of a space, is what the whole asks for in these rows.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <numeric>
#include <tuple>
#include <vector>

#include "linear/matrices.h"
#include "mq/fem/texel_part.h"
#include "mq/filter/stitch.h"
#include "mq/filter/weak_unknowns.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

using Key = std::tuple<int, int, int>;

/// A bust in 28 charts, each a region, and parts of it.
struct PartedBust {
  PartedBust()
      : sample(make_sample("bust", {.texture_size = 128, .triangles = 3000})),
        surface(make_surface(sample.mesh)),
        atlas(make_atlas(surface, {sample.texture})),
        space(surface, atlas),
        seams(surface, atlas),
        blocks(surface, atlas, seams, 16),
        owners{blocks, parted(blocks, 4)},
        psi(test::random_signal(space.size(), 2)) {
    for (int i = 0; i < space.size(); ++i) number[key_of(space.texels().places[std::size_t(i)])] = i;
    for (int p = 0; p < 4; ++p) parts.push_back(std::make_unique<TexelPart>(surface, atlas, seams, owners, p));
  }

  static Key key_of(const Texels::Place& at) { return {at.texture, at.y, at.x}; }
  int whole_row(const TexelPart& part, int i) const { return number.at(key_of(part.places()[std::size_t(i)])); }

  /// Rows of the whole, those of a part.
  Signal of_part(const TexelPart& part, const Signal& whole) const {
    Signal rows(part.space().size(), whole.cols());
    for (int i = 0; i < part.space().size(); ++i) rows.row(i) = whole.row(whole_row(part, i));
    return rows;
  }

  const std::vector<int>& labels() const { return space.texels().chart; }
  std::vector<int> labels_of(const TexelPart& part) const {
    std::vector<int> of(std::size_t(part.space().size()));
    for (std::size_t i = 0; i < of.size(); ++i) of[i] = labels()[std::size_t(whole_row(part, int(i)))];
    return of;
  }

  Sample sample;
  Surface surface;
  Atlas atlas;
  TexelSpace space;
  Seams seams;
  TexelBlocks blocks;
  BlockOwners owners;
  Signal psi;
  std::map<Key, int> number;
  std::vector<std::unique_ptr<TexelPart>> parts;
};

TEST(StitchByParts, AsksForTheSame) {
  const PartedBust bust;
  const SparseMatrix S = bust.space.stiffness();
  const Signal slopes = region_slopes(bust.space, S, bust.psi, bust.labels());
  const Signal continued = stitch_regions(bust.space, bust.psi, bust.labels()),
               level = level_borders(bust.space, S, bust.psi, bust.labels());
  EXPECT_EQ(stitch_regions(bust.space, bust.psi, bust.labels(), slopes), continued);
  double of_slopes = 0, of_continued = 0, of_level = 0;
  for (const auto& part : bust.parts) {
    const TexelSpace& space = part->space();
    const Signal psi = bust.of_part(*part, bust.psi);
    const std::vector<int> labels = bust.labels_of(*part);
    const Signal own_slopes = region_slopes(space, space.stiffness(), psi, labels);
    const Signal asked = stitch_regions(space, psi, labels, bust.of_part(*part, slopes)),
                 asked_level = level_borders(space, space.stiffness(), psi, labels);
    for (const int i : part->own()) {
      const int row = bust.whole_row(*part, i);
      of_slopes = std::max(of_slopes, (own_slopes.row(i) - slopes.row(row)).cwiseAbs().maxCoeff());
      of_continued = std::max(of_continued, (asked.row(i) - continued.row(row)).cwiseAbs().maxCoeff());
      of_level = std::max(of_level, (asked_level.row(i) - level.row(row)).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LT(of_slopes, 1e-6 * slopes.cwiseAbs().maxCoeff());
  EXPECT_LT(of_continued, 1e-8 * continued.cwiseAbs().maxCoeff());
  EXPECT_LT(of_level, 1e-8 * level.cwiseAbs().maxCoeff());
}

/// In rounds, each with what the others have found, weak texels come to where one pass over all of them brings them.
TEST(StitchByParts, BoundsWeakTexelsAsTheWholeDoes) {
  const PartedBust bust;
  const SparseMatrix S = bust.space.stiffness();
  std::vector<int> all(std::size_t(bust.space.size())), half, rest;
  std::iota(all.begin(), all.end(), 0);
  for (const int i : all) (i % 2 == 0 ? half : rest).push_back(i);
  const WeakUnknowns whole(S, S.diagonal(), bust.labels(), all), first(S, S.diagonal(), bust.labels(), half),
      second(S, S.diagonal(), bust.labels(), rest);
  Signal expected = bust.psi, found = bust.psi;
  EXPECT_TRUE(whole.bound(bust.psi, expected));
  EXPECT_FALSE(whole.bound(bust.psi, expected));
  for (bool changed = true; changed;) {
    changed = first.bound(bust.psi, found);
    changed = second.bound(bust.psi, found) || changed;
  }
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace mq
