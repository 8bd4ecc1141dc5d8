#pragma once
/// What a store of an evolving mesh is made of, piece by piece (docs/evolving_format.md), wherever it is kept.
///
/// Frames are told from those before them in their group; a group is begun when the last one has its frames, or when
/// most vertices of a segment are new.

#include <cstdint>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/evolving_motion.h"

namespace mq {

/// A block, and the manifest's line for it, with its line feed.
struct StorePiece {
  Bytes block = {};
  std::string line = {};
  bool begins_group = false;
};

/// What the next piece is told from.
struct StoreState {
  int segment = -1, group = -1, frames_in_group = 0;
  std::int64_t size = 0;  ///< of all blocks
  EvolvingSegment open = {};   ///< the segment added last
  CodingOrder order = {};
  MotionState motion = {};
};

class StoreCoder {
 public:
  StoreCoder() = default;

  /// Positions are multiples of `step`, texture coordinates of `uv_step`, a power of two; 0: as they are. A group has
  /// at most so many frames. Throws `InvalidInput` where one of these cannot be.
  StoreCoder(double step, double uv_step, int group_frames, StoreState state = {});

  /// The manifest's first line. `about` is a JSON object.
  std::string head(const std::string& blocks_name, const std::string& about) const;

  StorePiece add_segment(const EvolvingSegment& segment);

  /// Of the segment added last. One piece, or two where it begins a group. `measured`: a JSON object, or empty.
  std::vector<StorePiece> add_frame(int number, const std::vector<Vector3>& positions, const std::string& measured);

  double step() const { return step_; }

 private:
  StorePiece open_segment(const EvolvingSegment& before);

  double step_ = 0, uv_step_ = 0;
  int group_frames_ = 0;
  StoreState state_;
};

}  // namespace mq
