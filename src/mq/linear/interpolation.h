#pragma once
/// A transfer between levels for vectors in either precision.

#include <cstdint>
#include <vector>

#include "mq/linear/transfer.h"

namespace mq {

/// P of a `LevelTransfer` by rows and by columns. Vectors are rows × lanes (1 or 4).
template <class Real>
class Interpolation {
 public:
  Interpolation() = default;
  explicit Interpolation(const LevelTransfer& P);

  void restrict_to(int lanes, const Real* r, Real* b) const;     ///< b = Pᵀ·r
  void prolongate_add(int lanes, const Real* y, Real* x) const;  ///< x += P·y
  std::int64_t bytes() const;

 private:
  struct Lists {
    std::vector<int> starts = {0};
    std::vector<WeightedIndex> entries;
  };
  Lists parents_, children_;
};

extern template class Interpolation<float>;
extern template class Interpolation<double>;

}  // namespace mq
