#include "mq/base/apart.h"

#include <chrono>
#include <cmath>
#include <future>
#include <list>
#include <mutex>
#include <thread>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"

namespace mq {
namespace {

constexpr std::chrono::milliseconds between_looks{100};
constexpr double even_pace = 0.9;

/// How far work has come after this share of the time it was expected to take.
double fraction_after(double share) {
  return share < even_pace ? share
                           : 1 - (1 - even_pace) * std::exp((even_pace - share) / (1 - even_pace));
}

/// Threads nobody waits for any more. A process has one of these, as it has one set of threads.
class LeftBehind {
 public:
  ~LeftBehind() {
    for (std::thread& thread : threads_) thread.join();
  }

  void take(std::thread thread) {
    const std::lock_guard lock(mutex_);
    threads_.push_back(std::move(thread));
  }

 private:
  std::mutex mutex_;
  std::list<std::thread> threads_;
};

LeftBehind& left_behind() {
  static LeftBehind all;
  return all;
}

}  // namespace

void run_apart(std::function<void()> work, const Progress& progress, double expected_seconds) {
  progress.check();
  const Stopwatch watch;
  std::packaged_task<void()> task(std::move(work));
  std::future<void> done = task.get_future();
  LeftBehind& others = left_behind();
  std::thread thread(std::move(task));
  try {
    while (done.wait_for(between_looks) != std::future_status::ready)
      progress.at(fraction_after(watch.seconds() / expected_seconds));
  } catch (...) {  // Cancelled, or what a listener throws
    others.take(std::move(thread));
    throw;
  }
  thread.join();
  done.get();
}

}  // namespace mq
