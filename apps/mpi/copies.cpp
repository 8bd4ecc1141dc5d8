// All copies of a texel are compared by one process, whichever its place in the pictures says.
#include "copies.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "mq/atlas/coverage.h"

namespace mq::shared {
namespace {

struct Told {
  CopyRank rank;
  int process, row;
};

auto raster(const Texels::Place& at) { return std::tuple(at.texture, at.y, at.x); }

}  // namespace

SharedCopies::SharedCopies(const Processes& processes, const Surface& surface,
                           const std::optional<SeparatedAtlas>& apart, const TexelPart& part)
    : apart_(apart), part_(part) {
  if (!apart) return;
  std::vector<CopyRank> ranks;
  processes.together([&] {
    if (part.empty()) return;
    const std::vector<Coverage> coverage = texel_coverage(surface, part.atlas());
    const Texels& texels = part.space().texels();
    const Vector mass = part.space().lumped_mass();
    for (const int i : part.own()) {
      const Texels::Place& at = texels.places[std::size_t(i)];  // in the part's window
      ranks.emplace_back(*apart, part.places()[std::size_t(i)],
                         coverage[std::size_t(at.texture)].triangle(at.x, at.y), texels.chart[std::size_t(i)], mass[i]);
    }
  });
  processes.talking([&] { compare(processes, ranks); });
}

void SharedCopies::compare(const Processes& processes, const std::vector<CopyRank>& ranks) {
  const auto count = std::size_t(processes.count());
  std::vector<std::vector<Told>> sent(count);
  for (std::size_t n = 0; n < ranks.size(); ++n) {
    const Texels::Place& home = ranks[n].home;
    const auto judge = (std::size_t(home.texture) + std::size_t(home.y) / 16 + std::size_t(home.x) / 16) % count;
    sent[judge].push_back({ranks[n], processes.rank(), int(n)});
  }
  std::vector<Told> all;
  for (const auto& from : processes.exchange(sent)) all.insert(all.end(), from.begin(), from.end());
  std::ranges::sort(all, [](const Told& a, const Told& b) {
    if (raster(a.rank.home) != raster(b.rank.home)) return raster(a.rank.home) < raster(b.rank.home);
    return a.rank.comes_before(b.rank);
  });
  std::vector<std::vector<int>> first(count);  // rows that come first
  double shared = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto is_same = [&](std::size_t a, std::size_t b) {
      return b < all.size() && raster(all[a].rank.home) == raster(all[b].rank.home);
    };
    if (k > 0 && is_same(k - 1, k)) continue;
    first[std::size_t(all[k].process)].push_back(all[k].row);
    shared += is_same(k, k + 1);
  }
  shown_.assign(ranks.size(), 0);
  for (const auto& rows : processes.exchange(first))
    for (const int row : rows) shown_[std::size_t(row)] = 1;
  meant_ = shown_;
  for (std::size_t n = 0; n < ranks.size(); ++n)
    if (ranks[n].lies == CopyRank::Lies::covered) meant_[n] = 1;
  processes.sum({&shared, 1});
  shared_texels_ = std::int64_t(shared);
}

Texels::Place SharedCopies::home(int row) const {
  const Texels::Place& at = part_.places()[std::size_t(part_.own()[std::size_t(row)])];
  if (!apart_) return at;
  const SeparatedAtlas::Home home = apart_->home(at.texture, at.x, at.y);
  return {at.texture, home.x, home.y};
}

}  // namespace mq::shared
