#include "mq/linear/interpolation.h"

#include <array>
#include <type_traits>

#include "mq/base/parallel.h"

namespace mq {

template <class Real>
Interpolation<Real>::Interpolation(const LevelTransfer& P) {
  std::array<WeightedIndex, 4> parents;
  for (int i = 0; i < P.fine_rows(); ++i) {
    const int count = P.parents(i, parents);
    parents_.entries.insert(parents_.entries.end(), parents.begin(), parents.begin() + count);
    parents_.starts.push_back(int(parents_.entries.size()));
  }
  for (int j = 0; j < P.coarse_rows(); ++j) {
    P.children(j, children_.entries);
    children_.starts.push_back(int(children_.entries.size()));
  }
}

template <class Real>
void Interpolation<Real>::restrict_to(int lanes, const Real* r, Real* b) const {
  parallel_blocks(
      std::int64_t(children_.starts.size()) - 1, 1024, [&](std::int64_t begin, std::int64_t end) {
        const TransferRows rows{nullptr, begin, end};
        const int* starts = children_.starts.data();
        const WeightedIndex* entries = children_.entries.data();
        if constexpr (std::is_same_v<Real, float>)
          transfer_kernels().sums(lanes, starts, entries, rows, r, b);
        else
          transfer_kernels().sums_in_double(lanes, starts, entries, rows, r, b);
      });
}

template <class Real>
void Interpolation<Real>::prolongate_add(int lanes, const Real* y, Real* x) const {
  parallel_blocks(
      std::int64_t(parents_.starts.size()) - 1, 1024, [&](std::int64_t begin, std::int64_t end) {
        const TransferRows rows{nullptr, begin, end};
        const int* starts = parents_.starts.data();
        const WeightedIndex* entries = parents_.entries.data();
        if constexpr (std::is_same_v<Real, float>)
          transfer_kernels().add_sums(lanes, starts, entries, rows, y, x);
        else
          transfer_kernels().add_sums_in_double(lanes, starts, entries, rows, y, x);
      });
}

template <class Real>
std::int64_t Interpolation<Real>::bytes() const {
  return std::int64_t(8 * (parents_.entries.size() + children_.entries.size()) +
                      4 * (parents_.starts.size() + children_.starts.size()));
}

template class Interpolation<float>;
template class Interpolation<double>;

}  // namespace mq
