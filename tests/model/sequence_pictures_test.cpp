#include "mq/model/sequence_pictures.h"

#include <gtest/gtest.h>

#include "io/folder.h"
#include "model/sequences.h"

namespace mq {
namespace {

FollowedFrame frame(int number) {
  FollowedFrame frame;
  frame.number = number;
  frame.distance = {0.001, 0.002, 0.004};
  frame.kept = 90, frame.added = 10, frame.removed = 10;
  return frame;
}

TEST(SequencePlot, HasAPanelForWhatIsKnown) {
  EXPECT_TRUE(sequence_plot({followed_frame(0, ""), followed_frame(1, "")}).empty());
  std::vector<FollowedFrame> frames = {frame(0), frame(1), frame(2)};
  const int height = sequence_plot(frames).height();
  EXPECT_GT(height, 3 * 200);  // distances, triangles kept, triangles
  for (FollowedFrame& one : frames) one.drift = FollowedFrame::Drift{{1, 1, 1, 1}, 2};
  EXPECT_GT(sequence_plot(frames).height(), height + 200);
}

class SequenceStrip : public FolderTest {};

TEST_F(SequenceStrip, ShowsSomeOfTheFrames) {
  const std::vector<MemoryFrames::Frame> made = bending(2);
  EvolvingStore store(folder / "body.evolving");
  SequenceTracker(MemoryFrames(made), store, coarse()).run();
  const EvolvingReader reader(folder / "body.evolving");
  std::vector<int> asked;
  const Image<float> strip = sequence_strip(
      reader, [&](int f) { return asked.push_back(f), made[std::size_t(f)].model; }, View());
  EXPECT_EQ(asked, (std::vector{0, 1}));
  EXPECT_GT(strip.height(), 3 * 160);
  EXPECT_GT(strip.width(), 2 * 160);
}

}  // namespace
}  // namespace mq
