#pragma once
/// Small sequences that are followed, and who hears what is said meanwhile.

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "mq/io/model.h"
#include "mq/model/sequence_tracker.h"
#include "mq/sample/moving.h"

namespace mq {

/// A frame of a body in motion, with colours at its vertices and its material.
inline MemoryFrames::Frame moving_frame(const std::string& name, int number,
                                        const MovingOptions& options) {
  MovingFrame made = make_moving_frame(name, number, options);
  Model model;
  model.mesh = std::move(made.mesh);
  model.colors.channels = 3;
  for (const Vector3& color : made.colors)
    for (const double c : color) model.colors.values.push_back(float(c));
  return {number, std::move(model), std::move(made.material)};
}

inline std::vector<MemoryFrames::Frame> moving_frames(const std::string& name, int first, int last,
                                                      const MovingOptions& options) {
  std::vector<MemoryFrames::Frame> frames;
  for (int number = first; number <= last; ++number)
    frames.push_back(moving_frame(name, number, options));
  return frames;
}

/// A long body that bends.
inline std::vector<MemoryFrames::Frame> bending(int count) {
  return moving_frames("bending", 0, count - 1, {.triangles = 1000});
}

/// Two balls that meet in frame 11.
inline std::vector<MemoryFrames::Frame> merging(int first, int last) {
  return moving_frames("merging", first, last, {.period = 40, .triangles = 2500});
}

/// Options with nodes so far apart that triangles of these need not be cut, which is fast.
inline SequenceTrackerOptions coarse(SequenceTrackerOptions options = {}) {
  options.follow.track.node_spacing = options.follow.remeshing == Remeshing::none ? 0.1 : 0.12;
  return options;
}

/// Everything that was said.
struct Heard : Messages {
  std::string remarks, warnings, safe_now;
  void remark(const std::string& text) override { remarks += text + '\n'; }
  void warning(const std::string& text) override { warnings += text + '\n'; }
  void safe(const std::string& text) override { safe_now = text; }
};

/// Progress that is asked to stop once a step is reached whose path begins so.
class Stopper {
 public:
  explicit Stopper(std::string step) : step_(std::move(step)) {}
  Progress progress() {
    return Progress(
        [this](const ProgressEvent& event) {
          if (event.step.starts_with(step_)) stop_ = true;
        },
        &stop_);
  }

 private:
  std::string step_;
  std::atomic<bool> stop_{false};
};

}  // namespace mq
