// A component is known by the least number of its texels. Each process joins what its part of the matrix joins, and
// hears of the least numbers at its halo, until nothing changes anywhere. Sums are made by the owner of that texel.
#include "components.h"

#include <algorithm>
#include <limits>

#include "mq/linear/connected_components.h"

namespace mq::shared {

SharedComponents::SharedComponents(const Processes& processes, const TexelPart& part, const Numbering& numbering,
                                   const SparseMatrix& A)
    : numbering_(numbering) {
  std::vector<int> joined;
  processes.together([&] {
    if (!part.empty()) joined = connected_components(A);
  });
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::int64_t>& numbers = numbering.numbers();
  std::vector<std::int64_t> least(joined.empty() ? 0 : 1 + std::size_t(*std::ranges::max_element(joined)), none);
  const auto lower = [&](std::size_t i, std::int64_t number) {
    std::int64_t& known = least[std::size_t(joined[i])];
    if (number >= known) return false;
    known = number;
    return true;
  };
  for (std::size_t i = 0; i < joined.size(); ++i)
    if (numbers[i] >= 0) lower(i, numbers[i]);
  Vector told(Eigen::Index(joined.size()));
  for (bool changes = true; changes;) {
    for (std::size_t i = 0; i < joined.size(); ++i) told[Eigen::Index(i)] = double(least[std::size_t(joined[i])]);
    numbering.fill_halo({told.data(), std::size_t(told.size())}, 1);
    changes = false;
    for (std::size_t i = 0; i < joined.size(); ++i)
      if (numbers[i] >= 0) changes = lower(i, std::int64_t(told[Eigen::Index(i)])) || changes;
    changes = processes.largest(changes ? 1.0 : 0.0) > 0;
  }
  ids_ = least;
  std::ranges::sort(ids_);
  ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
  for (const int c : joined)
    component_.push_back(int(std::ranges::lower_bound(ids_, least[std::size_t(c)]) - ids_.begin()));
  // Of texels that no process has nothing is asked.
  std::vector<std::int64_t> wanted;
  for (const std::int64_t id : ids_)
    if (id != none && numbering.owner(id) != processes.rank()) wanted.push_back(id);
  others_.emplace(processes, numbering, wanted);
}

Signal SharedComponents::sums(const Signal& here) const {
  Signal own = Signal::Zero(numbering_.own_count(), here.cols());
  const auto row_of = [&](std::int64_t id) {
    const std::int64_t row = id - numbering_.first();
    return row >= 0 && row < numbering_.own_count() ? row : -1;
  };
  std::vector<Eigen::Index> of_others;
  for (std::size_t c = 0; c < ids_.size(); ++c)
    if (const auto row = row_of(ids_[c]); row >= 0)
      own.row(row) = here.row(Eigen::Index(c));
    else if (ids_[c] < std::numeric_limits<std::int64_t>::max())
      of_others.push_back(Eigen::Index(c));
  Signal theirs(std::ssize(of_others), here.cols());
  for (std::size_t n = 0; n < of_others.size(); ++n) theirs.row(Eigen::Index(n)) = here.row(of_others[n]);
  others_->add_to_owners(theirs, own);
  theirs = others_->fetched(own);
  Signal all = here;
  for (std::size_t c = 0; c < ids_.size(); ++c)
    if (const auto row = row_of(ids_[c]); row >= 0) all.row(Eigen::Index(c)) = own.row(row);
  for (std::size_t n = 0; n < of_others.size(); ++n) all.row(of_others[n]) = theirs.row(Eigen::Index(n));
  return all;
}

}  // namespace mq::shared
