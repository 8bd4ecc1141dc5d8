#include "background.h"

#include <utility>

#include "mq/base/error.h"

namespace mq::view {

void Background::start(std::function<void(const Progress&)> job) {
  if (thread_.joinable()) thread_.join();
  cancel_ = false;
  running_ = true;
  fraction_ = 0;
  thread_ = std::thread([this, job = std::move(job)] {
    const auto fail = [this](const std::string& words) {
      const std::lock_guard lock(mutex_);
      error_ = words;
    };
    try {
      job(Progress(
          [this](const ProgressEvent& event) {
            fraction_ = event.fraction;
            const std::lock_guard lock(mutex_);
            step_ = event.step;
          },
          &cancel_));
    } catch (const Cancelled&) {
    } catch (const std::bad_alloc&) {
      fail("not enough memory: use smaller textures, or a machine with more");
    } catch (const std::exception& error) {
      fail(error.what());
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

std::string Background::error() {
  const std::lock_guard lock(mutex_);
  return std::exchange(error_, {});
}

}  // namespace mq::view
