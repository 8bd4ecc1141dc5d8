#include "background.h"

#include <fmt/format.h>

#include <cmath>
#include <new>
#include <utility>

#include "mq/base/error.h"
#include "shell/duration.h"
#include "shell/run.h"
#include "shell/scratch.h"

namespace mq::view {

void Background::start(std::function<void(const Progress&)> job) {
  if (thread_.joinable()) thread_.join();
  cancel_ = false;
  running_ = true;
  fraction_ = 0;
  since_ = {};
  thread_ = std::thread([this, job = std::move(job)] {
    try {
      job(Progress(
          [this](const ProgressEvent& event) {
            fraction_ = event.fraction;
            const std::lock_guard lock(mutex_);
            step_ = event.step;
          },
          &cancel_));
    } catch (const Cancelled&) {
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
    }
    running_ = false;
  });
}

void Background::stop() {
  cancel_ = true;
  if (thread_.joinable()) thread_.join();
}

std::string Background::step() const {
  const std::lock_guard lock(mutex_);
  return step_;
}

std::string Background::how_far() const {
  return fmt::format("{:.0f} %{}", std::floor(100 * fraction()), app::estimate(app::seconds_left(fraction(), seconds())));
}

void Background::rethrow() {
  std::exception_ptr failure;
  {
    const std::lock_guard lock(mutex_);
    failure = std::exchange(failure_, nullptr);
  }
  if (!failure) return;
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(app::out_of_memory());
  }
}

std::string Background::error() {
  try {
    rethrow();
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace mq::view
