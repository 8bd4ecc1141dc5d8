#include "mq/fem/texel_copies.h"

#include <algorithm>

#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/copy_rank.h"

namespace mq {

TexelCopies::TexelCopies(const Surface& surface, const SeparatedAtlas& apart,
                         const TexelSpace& space)
    : apart_(apart), space_(space), offsets_{0} {
  for (const TextureSize& size : apart.pictures)
    offsets_.push_back(offsets_.back() + std::int64_t(size.width) * size.height);
  const std::vector<Coverage> coverage = texel_coverage(surface, apart.atlas);
  const Texels& texels = space.texels();
  const Vector mass = space.lumped_mass();
  const auto rank = [&](std::int64_t i) {
    const Texels::Place& at = texels.places[std::size_t(i)];
    return CopyRank(apart, at, coverage[std::size_t(at.texture)].triangle(at.x, at.y), texels.chart[std::size_t(i)],
                    mass[i]);
  };
  copies_.resize(std::size_t(texels.size()));
  parallel_for(texels.size(), [&](std::int64_t i) {
    const CopyRank own = rank(i);
    copies_[std::size_t(i)] = {number(own.home), int(i), int(own.lies)};
  });
  std::ranges::sort(copies_, [&](const Copy& a, const Copy& b) {
    if (a.texel != b.texel) return a.texel < b.texel;
    return rank(a.unknown).comes_before(rank(b.unknown));
  });
  is_shown_.assign(copies_.size(), 0);
  for (std::size_t i = 0; i < copies_.size(); ++i)
    if (i == 0 || copies_[i].texel != copies_[i - 1].texel)
      is_shown_[std::size_t(copies_[i].unknown)] = 1;
  for (std::size_t i = 1; i < copies_.size(); ++i)
    if (copies_[i].texel == copies_[i - 1].texel &&
        (i == 1 || copies_[i].texel != copies_[i - 2].texel))
      shared_.push_back(home(copies_[i].unknown));
}

std::int64_t TexelCopies::number(const Texels::Place& texel) const {
  return offsets_[std::size_t(texel.texture)] +
         std::int64_t(texel.y) * apart_.pictures[std::size_t(texel.texture)].width + texel.x;
}

Texels::Place TexelCopies::home(int unknown) const {
  const Texels::Place& at = space_.texels().places[std::size_t(unknown)];
  const SeparatedAtlas::Home home = apart_.home(at.texture, at.x, at.y);
  return {at.texture, home.x, home.y};
}

std::vector<int> TexelCopies::meant(const Texels::Place& texel) const {
  const auto all = std::ranges::equal_range(copies_, number(texel), {}, &Copy::texel);
  std::vector<int> unknowns;
  for (const Copy& copy : all)
    if (copy.rank == 0 || unknowns.empty()) unknowns.push_back(copy.unknown);
  return unknowns;
}

void TexelCopies::scatter(const Signal& signal, std::span<Image<float>> pictures) const {
  require(signal.rows() == space_.size() && pictures.size() == apart_.pictures.size() &&
              signal.cols() == pictures.front().channels(),
          "a signal of this space and one picture per texture are needed");
  parallel_for(std::ssize(copies_), [&](std::int64_t k) {
    if (k > 0 && copies_[std::size_t(k - 1)].texel == copies_[std::size_t(k)].texel) return;
    const int i = copies_[std::size_t(k)].unknown;
    const Texels::Place at = home(i);
    const auto pixel = pictures[std::size_t(at.texture)].pixel(at.x, at.y);
    for (int c = 0; c < signal.cols(); ++c) pixel[std::size_t(c)] = float(signal(i, c));
  });
}

}  // namespace mq
