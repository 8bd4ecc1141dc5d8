#pragma once
/// Positions as files that move have them: floats, in a unit of their own.

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/evolving_file.h"

namespace mq {

/// `x` in floats, of a frame (index) of the reader: a position, or how far one is from another. Throws `Unsupported`,
/// naming the file, the frame and the value, where floats, which `format` has, are too small for it.
inline Eigen::Vector3f as_floats(const Vector3& x, const EvolvingReader& reader, int frame, const char* format) {
  const Eigen::Vector3f floats = x.cast<float>();
  if (!floats.allFinite())
    throw Unsupported(fmt::format(
        "{}, frame {}: found a vertex at {:.6g}, {:.6g}, {:.6g}, wanted what the floats of {} "
        "hold, at most 3.4e38; scale it down, or write a file a frame (frame_%04d.ply)",
        reader.manifest().string(), reader.frames()[std::size_t(frame)].number, x.x(), x.y(), x.z(), format));
  return floats;
}

}  // namespace mq
