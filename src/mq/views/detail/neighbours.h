#pragma once
/// Observations of one photograph on patches that touch.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/views/view_choice.h"

namespace mq {

/// visit(k, beside, weight) for observations of one view on patches that touch, once each.
void for_each_pair(const Patches& patches, const Observations& observations, const auto& visit) {
  for (const Patches::Link& link : patches.links)
    for (std::int64_t k = observations.offsets[link.a]; k < observations.offsets[link.a + 1]; ++k) {
      const std::int64_t beside = observations.number_of(link.b, observations.all[std::size_t(k)].view);
      if (beside >= 0) visit(std::size_t(k), std::size_t(beside), link.weight);
    }
}

/// The patches that each patch touches.
class Neighbours {
 public:
  struct Side {
    int patch;
    float weight;  ///< as of `Patches::Link`
  };

  explicit Neighbours(const Patches& patches) : offsets_(std::size_t(patches.count()) + 1, 0) {
    for (const Patches::Link& link : patches.links) ++offsets_[link.a + 1], ++offsets_[link.b + 1];
    for (std::size_t p = 1; p < offsets_.size(); ++p) offsets_[p] += offsets_[p - 1];
    sides_.resize(std::size_t(offsets_.back()));
    std::vector<std::int64_t> next(offsets_.begin(), offsets_.end() - 1);
    for (const Patches::Link& link : patches.links) {
      sides_[next[link.a]++] = {link.b, link.weight};
      sides_[next[link.b]++] = {link.a, link.weight};
    }
  }

  std::span<const Side> of(int patch) const {
    return {sides_.data() + offsets_[patch], std::size_t(offsets_[patch + 1] - offsets_[patch])};
  }

 private:
  std::vector<std::int64_t> offsets_;
  std::vector<Side> sides_;
};

}  // namespace mq
