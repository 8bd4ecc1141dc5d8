#pragma once
/// Work on a thread of its own, so that the window never waits for it.

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "mq/base/progress.h"
#include "mq/base/stopwatch.h"

namespace mq::view {

/// One job at a time. All calls belong to the thread that made it.
class Background {
 public:
  Background() = default;
  ~Background() { stop(); }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Begins a job; none may be running. What it throws is kept for `error`, but for `Cancelled`.
  void start(std::function<void(const Progress&)> job);
  bool busy() const { return running_; }
  /// Asks it to stop, without waiting until it has.
  void cancel() { cancel_ = true; }
  /// Asks it to stop and waits until it has.
  void stop();

  double fraction() const { return fraction_; }
  std::string step() const;
  /// Since the job began.
  double seconds() const { return since_.seconds(); }
  /// "40 %, about 12 s left".
  std::string how_far() const;
  /// Why the last job failed, once; empty: it did not.
  std::string error();
  /// Throws what the last job threw, once.
  void rethrow();

 private:
  std::thread thread_;
  Stopwatch since_;
  std::atomic<bool> running_ = false, cancel_ = false;
  std::atomic<double> fraction_ = 0;
  mutable std::mutex mutex_;
  std::string step_;
  std::exception_ptr failure_;
};

}  // namespace mq::view
