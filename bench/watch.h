#pragma once
/// What benches time with.

#include <chrono>
#include <ctime>

namespace mq::bench {

/// Seconds of the processor, all threads together, or of the clock on the wall.
class Watch {
 public:
  explicit Watch(bool wall) : wall_(wall), start_(now()) {}
  double seconds() const { return now() - start_; }

 private:
  double now() const {
    if (!wall_) return double(std::clock()) / CLOCKS_PER_SEC;
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  bool wall_;
  double start_;
};

template <class Work>
double seconds_of(bool wall, const Work& work) {
  const Watch watch(wall);
  work();
  return watch.seconds();
}

}  // namespace mq::bench
