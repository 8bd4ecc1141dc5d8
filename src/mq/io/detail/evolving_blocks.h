#pragma once
/// Positions in steps, checksums, and the bytes of the blocks of an evolving mesh's store of version 1, which is only
/// read (docs/evolving_format.md).
///
/// Numbers are written as LEB128: seven bits a byte, the lowest first, the eighth says that more
/// follow. Those with a sign are folded first: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...

#include <cstdint>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/bytes.h"

namespace mq {

/// CRC-32 of IEEE 802.3, as in PNG and zip.
std::uint32_t crc32(ByteView bytes);

/// Coordinates in steps, x y z of each vertex. Throws `InvalidInput` where one is not finite or has
/// more than 2⁵⁰ steps.
std::vector<std::int64_t> in_steps(const std::vector<Vector3>& positions, double step);
std::vector<Vector3> from_steps(const std::vector<std::int64_t>& coordinates, double step);

/// A segment and the coordinates that its frames are coded against.
struct SegmentBlock {
  EvolvingSegment segment;
  std::vector<std::int64_t> key;
};

/// Throws `IoError` beginning with `what` where the bytes end too early, go on too long or say
/// something that is no segment (`check`).
SegmentBlock decode_segment(ByteView bytes, const std::string& what);

/// Coordinates of a frame: of c − key the difference from the vertex before.
std::vector<std::int64_t> decode_frame(ByteView bytes, const std::vector<std::int64_t>& key,
                                       const std::string& what);

}  // namespace mq
