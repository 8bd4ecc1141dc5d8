#include "mq/views/patches.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// The links of one patch to those of higher numbers.
std::vector<Patches::Link> links_of(const Patches& patches, const SparseMatrix& stiffness, int patch, int side) {
  std::vector<int> others;  // one per coupling
  for (std::int64_t k = patches.offsets[patch]; k < patches.offsets[patch + 1]; ++k)
    for (SparseMatrix::InnerIterator it(stiffness, patches.members[k]); it; ++it)
      if (const int other = patches.of[it.col()]; other > patch) others.push_back(other);
  std::ranges::sort(others);
  std::vector<Patches::Link> links;
  for (std::size_t begin = 0, end; begin < others.size(); begin = end) {
    for (end = begin; end < others.size() && others[end] == others[begin];) ++end;
    links.push_back({patch, others[begin], float(end - begin) / float(3 * side)});
  }
  return links;
}

}  // namespace

std::vector<int> Patches::samples(int patch, int number) const {
  const std::int64_t first = offsets[patch], all = size(patch);
  const std::int64_t wanted = std::min<std::int64_t>(all, number);
  std::vector<int> chosen;
  for (std::int64_t k = 0; k < wanted; ++k)
    chosen.push_back(members[first + (2 * k + 1) * all / (2 * wanted)]);
  return chosen;
}

Patches make_patches(const Texels& texels, const SparseMatrix& stiffness, int side) {
  require(side >= 1 && stiffness.rows() == texels.size(),
          "patches need a side of 1 or more and the matrix of these texels");
  const int n = texels.size();
  const auto square = [&](int i) {
    const Texels::Place& at = texels.places[i];
    return std::tuple(at.texture, texels.chart[i], at.y / side, at.x / side);
  };
  Patches patches;
  patches.members.resize(n);
  std::iota(patches.members.begin(), patches.members.end(), 0);
  std::ranges::stable_sort(patches.members, [&](int i, int j) { return square(i) < square(j); });
  patches.of.resize(n);
  for (int k = 0; k < n; ++k) {
    const int i = patches.members[k];
    if (k == 0 || square(patches.members[k - 1]) != square(i)) patches.offsets.push_back(k);
    patches.of[i] = int(patches.offsets.size()) - 1;
  }
  patches.offsets.push_back(n);

  std::vector<std::vector<Patches::Link>> links(patches.count());
  parallel_for(
      patches.count(), [&](std::int64_t p) { links[p] = links_of(patches, stiffness, int(p), side); }, 64);
  for (const std::vector<Patches::Link>& some : links)
    patches.links.insert(patches.links.end(), some.begin(), some.end());
  return patches;
}

}  // namespace mq
