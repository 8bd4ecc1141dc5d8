#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/filter/stitch.h"

namespace mq {

BeyondBorders::BeyondBorders(const SignalSpace& space, std::span<const int> labels, int channels) {
  std::vector<std::pair<int, int>> asked;  // photograph, unknown
  space.for_each_mixed_element(labels, [&](const Element& element) {
    for (const int i : element.unknowns)
      if (labels[i] == unseen) return;
    for (const int i : element.own)
      for (const int j : element.unknowns)
        if (labels[j] != labels[i]) asked.emplace_back(labels[i], j);
  });
  std::ranges::sort(asked);
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  const int photographs = labels.empty() ? 0 : std::ranges::max(labels) + 1;
  offsets_.assign(std::size_t(std::max(photographs, 0)) + 1, 0);
  for (const auto& [photograph, unknown] : asked) {
    ++offsets_[std::size_t(photograph) + 1];
    unknowns_.push_back(unknown);
  }
  for (std::size_t k = 1; k < offsets_.size(); ++k) offsets_[k] += offsets_[k - 1];
  known_.assign(unknowns_.size(), 0);
  values_ = Signal::Zero(std::ssize(unknowns_), channels);
}

std::span<const int> BeyondBorders::unknowns_of(int photograph) const {
  if (photograph < 0 || photograph + 1 >= std::ssize(offsets_)) return {};
  const std::ptrdiff_t begin = offsets_[std::size_t(photograph)], end = offsets_[std::size_t(photograph) + 1];
  return {unknowns_.data() + begin, std::size_t(end - begin)};
}

std::ptrdiff_t BeyondBorders::place_of(int photograph, int unknown) const {
  const std::span<const int> asked = unknowns_of(photograph);
  const auto at = std::ranges::lower_bound(asked, unknown);
  return at == asked.end() || *at != unknown ? -1 : offsets_[std::size_t(photograph)] + (at - asked.begin());
}

void BeyondBorders::put(int photograph, int unknown, const Eigen::RowVectorXd& values) {
  const std::ptrdiff_t at = place_of(photograph, unknown);
  require(at >= 0 && values.size() == values_.cols(),
          fmt::format("nothing is asked of photograph {} at unknown {}, or other channels", photograph, unknown));
  values_.row(at) = values;
  known_[std::size_t(at)] = 1;
}

bool BeyondBorders::find(int photograph, int unknown, Eigen::RowVectorXd& values) const {
  const std::ptrdiff_t at = place_of(photograph, unknown);
  if (at < 0 || !known_[std::size_t(at)]) return false;
  values = values_.row(at);
  return true;
}

}  // namespace mq
