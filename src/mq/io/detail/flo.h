#pragma once
/// The bytes of .flo files of optical flow (`flow_file.h`).

#include <span>
#include <string>

#include "mq/image/image.h"
#include "mq/io/bytes.h"

namespace mq {

/// Pairs of floats, right and down, of every pixel, NaN where a file says that it is not known.
/// `name` is for messages. Throws `IoError` on any other head or length.
Image<float> flow_from_bytes(std::span<const std::byte> bytes, const std::string& name);

/// The same bytes again; what is not finite is unknown.
Bytes bytes_of_flow(const Image<float>& field);

/// Vectors of which a part is 10⁹ or beyond, or not a number, are unknown: both parts NaN.
void mark_unknown_flow(Image<float>& field);

}  // namespace mq
