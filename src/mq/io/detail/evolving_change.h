#pragma once
/// A segment as what is new in it since the segment before (docs/evolving_format.md). Since an empty segment, it is
/// the whole.

#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/evolving_motion.h"

namespace mq {

/// So many vertices, and triangles, and texture coordinates, may a block of this size add, which bounds memory before
/// it is decoded. Blocks of what would be smaller are filled up with bytes of 0.
constexpr std::int64_t most_added_per_byte = 16;

/// Of each vertex which one of `before` it was, -1: none, by ids.
std::vector<int> vertices_before(const EvolvingSegment& segment, const EvolvingSegment& before);

/// In which positions of a segment are coded after a frame that leaves this motion; none: in the first of a group.
CodingOrder order_of(const EvolvingSegment& segment, const MotionState& motion);

/// Texture coordinates are rounded to multiples of `uv_step`, a power of two; or where that is 0, as they are, to the
/// bit. Where one has more than 2⁵⁰ steps, all are as they are.
Bytes encode_change(const EvolvingSegment& segment, const EvolvingSegment& before, double uv_step);

/// Throws `IoError` beginning with `what` where the bytes say no segment (`check`).
EvolvingSegment decode_change(ByteView bytes, const EvolvingSegment& before, const std::string& what);

}  // namespace mq
