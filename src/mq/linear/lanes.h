#pragma once
/// Vectors of a few floats per unknown, laid out for kernels that serve all channels at once.

#include <memory>
#include <new>

#include "mq/base/parallel_values.h"

namespace mq {

/// rows × lanes floats, a row's lanes adjacent; one channel has 1 lane, two to four have 4, up to eight have 8.
/// Kernels load whole vector registers, so that up to `margin` floats before the first row and
/// behind the last may be read; they are zero.
class LaneVector {
 public:
  static constexpr int margin = 32;

  LaneVector() = default;
  LaneVector(std::int64_t rows, int lanes)
      : size_(rows * lanes), lanes_(lanes), values_(allocate(size_ + 2 * margin)) {
    clear();
  }

  float* data() { return values_.get() + margin; }
  const float* data() const { return values_.get() + margin; }
  std::int64_t size() const { return size_; }
  int lanes() const { return lanes_; }

  void clear() {
    if (values_) parallel_fill(values_.get(), size_ + 2 * margin, 0.0F);
  }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Free {
    void operator()(float* p) const { ::operator delete[](p, alignment); }
  };
  static float* allocate(std::int64_t count) {
    return static_cast<float*>(::operator new[](sizeof(float) * count, alignment));
  }

  std::int64_t size_ = 0;
  int lanes_ = 0;
  std::unique_ptr<float[], Free> values_;
};

/// The lanes that serve `channels` channels, at most 8.
inline int lanes_for(int channels) { return channels == 1 ? 1 : channels <= 4 ? 4 : 8; }

}  // namespace mq
