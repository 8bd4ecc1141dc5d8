#include "mq/flow/texture_levels.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mq/atlas/coverage.h"
#include "mq/atlas/separate_overlaps.h"
#include "mq/base/parallel.h"
#include "mq/flow/detail/transfer_weights.h"

namespace mq {
namespace {

/// A texture of which fewer texels lie inside charts would hardly be continuous over its seams.
constexpr double least_interior = 0.4;

/// What is stretched more is a sliver; smoothness over it would be all that single precision sees.
constexpr double most_stretch = 16;

double share_inside(const TexelSpace& space) {
  const std::vector<char>& interior = space.texels().interior;
  return double(std::ranges::count(interior, 1)) / double(std::max<std::size_t>(1, interior.size()));
}

/// Of models more of whose texels than this show several places of the surface, as those of mirrored halves do, all these
/// places have one field; of others it is a sliver that folds.
constexpr double few_overlaps = 1e-3;

bool share_places(const Surface& surface, const Atlas& atlas) {
  if (std::ranges::count(atlas.textures, Wrap::repeat, &TextureSize::wrap) > 0) return true;
  const std::vector<Coverage> coverage = texel_coverage(surface, atlas);
  return double(overlapping_texels(coverage)) > few_overlaps * atlas.texel_area;
}

/// The atlas at another size. As charts are no farther apart there than texels, those that would share some are moved, for
/// what they have in common would tie places of the surface to each other that have nothing to do with each other.
Atlas at_size(const Surface& surface, const std::vector<TextureSize>& sizes, bool apart) {
  Atlas atlas = make_atlas(surface, sizes, {.flipped = AtlasOptions::Flipped::keep});
  if (!apart || refused(atlas.defects)) return atlas;
  std::optional<SeparatedAtlas> separated = separate_overlaps(surface, atlas);
  return separated ? std::move(separated->atlas) : std::move(atlas);
}

/// Where the charts of one atlas are in one of another size.
class ChartsElsewhere {
 public:
  ChartsElsewhere(const Surface& surface, const FlowTexture& from, const FlowTexture& to)
      : to_(to), homes_(from.atlas().charts.size()) {
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const int chart = from.atlas().chart[std::size_t(t)], there = to.atlas().chart[std::size_t(t)];
      if (chart < 0 || there < 0) continue;
      std::vector<Home>& homes = homes_[std::size_t(chart)];
      if (std::ranges::find(homes, there, &Home::chart) != homes.end()) continue;
      const auto corner = [&](const FlowTexture& texture) {
        const TexelPoint& p = texture.atlas().corners[std::size_t(t)][0];
        return Vector2(p.column() + 0.5, p.row() + 0.5);
      };
      const int picture = surface.mesh.texture(t);
      const Vector2 scale = to.own_size(picture).cwiseQuotient(from.own_size(picture));
      homes.push_back({there, picture, scale, corner(to) - corner(from).cwiseProduct(scale)});
    }
  }

  /// The place there; of a chart that is in parts there, in the one that has the most of what is looked up. None: nowhere.
  std::optional<ChartPlace> operator()(int chart, const Vector2& texel) const {
    std::optional<ChartPlace> best;
    double most = -1;
    for (const Home& home : homes_[std::size_t(chart)]) {
      const Vector2 there = (texel + Vector2(0.5, 0.5)).cwiseProduct(home.scale) + home.shift - Vector2(0.5, 0.5);
      const ChartPlace place = to_.domain().place(home.chart, home.texture, there);
      if (homes_[std::size_t(chart)].size() == 1) return place;
      double share = 0;
      to_.domain().for_each_corner(place, [&](int j, double weight) {
        if (to_.space().texels().chart[std::size_t(j)] == home.chart) share += weight;
      });
      if (share > most) most = share, best = place;
    }
    return best;
  }

 private:
  struct Home {
    int chart = 0, texture = 0;
    Vector2 scale, shift;  ///< of places from the corner of the picture
  };
  const FlowTexture& to_;
  std::vector<std::vector<Home>> homes_;  ///< per chart
};

std::shared_ptr<const BlockTransfer> transfer_between(const Surface& surface, const FlowTexture& fine,
                                                       const FlowTexture& coarse) {
  const ChartsElsewhere elsewhere(surface, fine, coarse);
  const int rows = fine.size();
  std::vector<std::vector<BlockTransfer::Entry>> parts(std::size_t((rows + 4095) / 4096));
  std::vector<int> counts(std::size_t(rows), 0);
  parallel_blocks(rows, 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<BlockTransfer::Entry>& part = parts[std::size_t(begin / 4096)];
    for (std::int64_t i = begin; i < end; ++i) {
      const ChartPlace& place = fine.starts().places[std::size_t(i)];
      if (place.chart < 0) continue;
      const std::optional<ChartPlace> there = elsewhere(place.chart, fine.domain().texel(place));
      if (!there) continue;
      const TangentPlane plane = fine.vectors().plane(int(i));
      const std::size_t before = part.size();
      coarse.domain().for_each_read(*there, [&](int j, double weight) {
        const std::complex<double> turn = weight * coarse.vectors().plane(j).turn(plane);
        part.push_back({j, float(turn.real()), float(turn.imag())});
      });
      counts[std::size_t(i)] = int(part.size() - before);
    }
  });
  auto P = std::make_shared<BlockTransfer>();
  P->columns = coarse.size();
  for (const int count : counts) P->starts.push_back(P->starts.back() + count);
  for (const auto& part : parts) P->entries.insert(P->entries.end(), part.begin(), part.end());
  P->finish();
  return P;
}

}  // namespace

FlowTexture::FlowTexture(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Progress& progress)
    : sizes_(atlas.textures),
      atlas_(&atlas),
      space_(&space),
      vectors_(surface, atlas, space),
      domain_(surface, atlas, space, progress),
      starts_(domain_.starts()),
      mass_(space.lumped_mass().cwiseMax(0)),
      limits_(vectors_.bounded(most_stretch)) {}

const std::vector<std::shared_ptr<const BlockTransfer>>& FlowTexture::transfers() const {
  // Fields are as smooth as two texels at least.
  if (transfers_.empty()) transfers_ = vectors_.transfers(1, 4 * spacing() * spacing());
  return transfers_;
}

Signal FlowTexture::shown(const Signal& signal) const {
  Signal result = signal;
  parallel_for(size(), [&](std::int64_t i) {
    if (starts_.outside[std::size_t(i)]) domain_.value(signal, starts_.places[std::size_t(i)], result.middleRows(i, 1));
  });
  return result;
}

FlowTextures::FlowTextures(const Surface& surface, const Atlas& atlas, const TexelSpace& space, int coarsest,
                           const Progress& progress) {
  textures_.push_back(std::make_unique<FlowTexture>(surface, atlas, space, progress.step("order cells", 0.5)));
  const bool apart = !share_places(surface, atlas);
  std::vector<TextureSize> sizes = atlas.textures;
  while (textures_.back()->size() > coarsest) {
    const FlowTexture& fine = *textures_.back();
    for (TextureSize& size : sizes) size.width = (size.width + 1) / 2, size.height = (size.height + 1) / 2;
    auto coarse_atlas = std::make_unique<const Atlas>(at_size(surface, sizes, apart));
    if (refused(coarse_atlas->defects)) break;  // so few texels that charts vanish
    auto coarse_space = std::make_unique<const TexelSpace>(surface, *coarse_atlas, TexelSpaceOptions{},
                                                           progress.step("coarser textures", 0.3));
    if (share_inside(*coarse_space) < least_interior) break;
    auto coarse = std::make_unique<FlowTexture>(surface, *coarse_atlas, *coarse_space);
    coarse->sizes_ = sizes;
    coarse->own_atlas_ = std::move(coarse_atlas);
    coarse->own_space_ = std::move(coarse_space);
    transfers_.push_back(transfer_between(surface, fine, *coarse));
    textures_.push_back(std::move(coarse));
  }
  progress.at(1);
}

Signal FlowTextures::restricted(int m, const Signal& signal) const {
  const BlockTransfer& P = *transfers_[std::size_t(m)];
  const FlowTexture& fine = *textures_[std::size_t(m)];
  Signal coarse = Signal::Zero(P.columns, signal.cols());
  std::vector<char> empty(std::size_t(P.columns), 0);
  parallel_for(P.columns, [&](std::int64_t j) {
    double sum = 0;
    for (int c = P.child_starts[std::size_t(j)]; c < P.child_starts[std::size_t(j) + 1]; ++c) {
      const int i = P.children[std::size_t(c)].column;
      if (fine.starts().outside[std::size_t(i)]) continue;
      const double weight = fine.lumped_mass()[i] * weight_of(P.children[std::size_t(c)]);
      coarse.row(j) += weight * signal.row(i);
      sum += weight;
    }
    if (sum > 0)
      coarse.row(j) /= sum;
    else
      empty[std::size_t(j)] = 1;
  });
  if (std::ranges::count(empty, 1) == 0) return coarse;
  // Texels that no centre of a finer one is next to: the mean of what they are coupled to.
  const SparseMatrix pattern = textures_[std::size_t(m) + 1]->space().stiffness();
  const Signal known = coarse;
  for (int j = 0; j < P.columns; ++j) {
    if (!empty[std::size_t(j)]) continue;
    double count = 0;
    for (SparseMatrix::InnerIterator entry(pattern, j); entry; ++entry)
      if (!empty[std::size_t(entry.col())]) {
        coarse.row(j) += known.row(entry.col());
        ++count;
      }
    if (count > 0) coarse.row(j) /= count;
  }
  return coarse;
}

Signal FlowTextures::prolongated_signal(int m, const Signal& signal) const {
  return prolongated_by_weights(*transfers_[std::size_t(m)], signal);
}

}  // namespace mq
