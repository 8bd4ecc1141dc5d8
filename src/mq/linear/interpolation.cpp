#include "mq/linear/interpolation.h"

#include <array>

#include "mq/base/parallel.h"
#include "mq/linear/real_lanes.h"

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
  parallel_for(std::int64_t(children_.starts.size()) - 1, [&](std::int64_t coarse) {
    with_constant_lanes(lanes, [&]<int L>() {
      typename RealLanes<Real, L>::Type sum{};
      for (int e = children_.starts[coarse]; e < children_.starts[coarse + 1]; ++e)
        sum += Real(children_.entries[e].weight) * row_of<L>(r, children_.entries[e].index);
      set_row<L>(b, coarse, sum);
    });
  });
}

template <class Real>
void Interpolation<Real>::prolongate_add(int lanes, const Real* y, Real* x) const {
  parallel_for(std::int64_t(parents_.starts.size()) - 1, [&](std::int64_t fine) {
    with_constant_lanes(lanes, [&]<int L>() {
      auto sum = row_of<L>(x, fine);
      for (int e = parents_.starts[fine]; e < parents_.starts[fine + 1]; ++e)
        sum += Real(parents_.entries[e].weight) * row_of<L>(y, parents_.entries[e].index);
      set_row<L>(x, fine, sum);
    });
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
