#include <cstdlib>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_uvs.h"

/// Any bytes are refused, or are a segment: by itself, after another one, in the format's version 1; or positions. What
/// they say comes back when it is written again.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  if (size == 0) return 0;
  const ByteView bytes = std::as_bytes(std::span(data, size)).subspan(1);
  EvolvingSegment before{{0, 1, 2, 3, 4}, {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}, {0, 1, 2}, {{0, 0}, {1, 0}, {0, 1}}, {}};
  before.corner_uvs = {{0, 1, 2}, {2, 1, 0}, {-1, 0, 1}};
  MotionState motion;
  motion.advance({0, 0, 0, 9, 0, 0, 0, 9, 0, 9, 9, 0, 0, 18, 0});
  try {
    switch (data[0] % 4) {
      case 0:
      case 1: {
        const EvolvingSegment from = data[0] % 4 == 0 ? EvolvingSegment{} : before;
        const EvolvingSegment found = decode_change(bytes, from, "fuzz");
        const EvolvingSegment again = decode_change(encode_change(found, from, 0), from, "again");
        if (again.triangles != found.triangles || again.uvs != found.uvs || again.vertex_ids != found.vertex_ids)
          std::abort();
        break;
      }
      case 2:
        check(decode_segment(bytes, "fuzz").segment);
        break;
      default: {
        const CodingOrder order = order_of(before, motion);
        const std::vector<std::int64_t> found = decode_positions(bytes, order, motion, "fuzz");
        if (decode_positions(encode_positions(found, order, motion), order, motion, "again") != found) std::abort();
      }
    }
  } catch (const IoError&) {
  }
  return 0;
}
