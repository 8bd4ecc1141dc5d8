#pragma once
/// Positions of a frame, predicted in space and in time (docs/evolving_format.md).

#include <cstdint>
#include <string>
#include <vector>

#include "mq/io/bytes.h"
#include "mq/io/detail/coding_order.h"

namespace mq {

/// The frame before, as far as the next one is predicted from it: coordinates x, y, z of each vertex in steps, and
/// how they changed from the one before that. Empty: none.
struct MotionState {
  std::vector<std::int64_t> coordinates, change;

  bool empty() const { return coordinates.empty(); }

  /// Goes on to the next frame of the same vertices.
  void advance(std::vector<std::int64_t> next);
};

/// The same for the vertices of another segment: `from` says of each which one it was, -1: new, at the mean of its
/// neighbours.
MotionState carried_over(const MotionState& before, const std::vector<int>& from,
                         const std::vector<Triangle>& triangles);

Bytes encode_positions(const std::vector<std::int64_t>& coordinates, const CodingOrder& order,
                       const MotionState& before);

/// Throws `IoError` beginning with `what` where the bytes are no positions of these vertices.
std::vector<std::int64_t> decode_positions(ByteView bytes, const CodingOrder& order, const MotionState& before,
                                           const std::string& what);

}  // namespace mq
