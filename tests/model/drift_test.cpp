// A body of which the true correspondence is known, followed for a hundred frames.
#include <gtest/gtest.h>

#include "model/sequences.h"

namespace mq {
namespace {

/// In edges of the template, the mean over the vertices of each frame.
std::vector<double> drift_of(const MemoryFrames& frames, TemplateFollowerOptions::Colours colours) {
  MemoryStore store;
  std::vector<double> drift;
  for (const FollowedFrame& frame :
       SequenceTracker(frames, store, {.follow = {.truth = Truth::material, .colours = colours}}).run().frames)
    drift.push_back(frame.drift->mean_edges);
  return drift;
}

/// Colours hold what by its shape alone slides along the surface.
TEST(SequenceTracker, KeepsWithinAQuarterOfAnEdgeForAHundredFramesByColours) {
  using Colours = TemplateFollowerOptions::Colours;
  const std::vector<double> by_colours =
      drift_of(MemoryFrames(moving_frames("twisting", 0, 100, {.triangles = 4000})), Colours::used);
  ASSERT_EQ(by_colours.size(), 101U);
  double sum = 0;
  for (const double each : by_colours) sum += each;
  EXPECT_LE(sum / double(by_colours.size()), 0.25);
  const std::vector<double> by_shape =
      drift_of(MemoryFrames(moving_frames("twisting", 0, 25, {.triangles = 4000})), Colours::left);
  EXPECT_GE(by_shape.back(), 2 * by_colours[by_shape.size() - 1]);
}

}  // namespace
}  // namespace mq
