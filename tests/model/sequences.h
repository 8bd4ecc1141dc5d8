#pragma once
/// Small sequences that are followed, what is known of them then, and who hears what is said
/// meanwhile.

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "mq/io/model.h"
#include "mq/model/sequence_tracker.h"
#include "sample/moving_bodies.h"

namespace mq {

/// A body in motion, with colours at its vertices and its material.
inline std::vector<MemoryFrames::Frame> moving_frames(const std::string& name, int first, int last,
                                                      const MovingOptions& options) {
  std::vector<MemoryFrames::Frame> frames;
  for (MovingFrame& made : moving_sequence(name, first, last, options)) {
    Model model;
    model.mesh = std::move(made.mesh);
    model.colors.channels = 3;
    for (const Vector3& color : made.colors)
      for (const double c : color) model.colors.values.push_back(float(c));
    frames.push_back({first + int(frames.size()), std::move(model), std::move(made.material)});
  }
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

/// What is known of frames but for the time that it took.
inline std::vector<std::string> without_seconds(std::vector<FollowedFrame> frames) {
  std::vector<std::string> texts;
  for (FollowedFrame& frame : frames) {
    frame.seconds = 0;
    if (frame.match) frame.match->seconds = {};
    if (frame.match && frame.match->remesh_seconds) frame.match->remesh_seconds = 0;
    texts.push_back(followed_text(frame));
  }
  return texts;
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
