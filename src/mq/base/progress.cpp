#include "mq/base/progress.h"

#include <algorithm>
#include <mutex>

#include "mq/base/error.h"

namespace mq {

struct Progress::Root {
  Listener listener;
  const std::atomic<bool>* cancel = nullptr;
  std::mutex mutex;
  double fraction = 0;
};

Progress::Progress(Listener listener, const std::atomic<bool>* cancel)
    : root_(std::make_shared<Root>()) {
  root_->listener = std::move(listener);
  root_->cancel = cancel;
}

Progress Progress::step(const std::string& name, double share) const {
  Progress child;
  if (!root_) return child;
  check();
  share = std::clamp(share, 0.0, 1.0 - given_);
  child.root_ = root_;
  const bool is_called_so = path_ == name || path_.ends_with(" / " + name);
  if (path_.empty())
    child.path_ = name;
  else
    child.path_ = is_called_so ? path_ : path_ + " / " + name;
  child.begin_ = begin_ + length_ * given_;
  child.length_ = length_ * share;
  given_ += share;
  child.at(0);
  return child;
}

void Progress::at(double fraction, const std::string& detail) const {
  if (!root_) return;
  check();
  if (!root_->listener) return;
  const std::lock_guard lock(root_->mutex);
  root_->fraction =
      std::max(root_->fraction, begin_ + length_ * std::clamp(fraction, 0.0, 1.0));
  root_->listener({path_, root_->fraction, detail});
}

void Progress::check() const {
  if (root_ && root_->cancel && root_->cancel->load(std::memory_order_relaxed)) throw Cancelled();
}

}  // namespace mq
