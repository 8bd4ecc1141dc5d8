#pragma once
/// Buffer views compressed by meshopt (EXT_meshopt_compression, also under its later name
/// KHR_meshopt_compression where the stream is of the first version).

#include <string>
#include <utility>

#include "mq/io/detail/gltf_file.h"

namespace mq {

/// The extension of a buffer view and its name; null without.
std::pair<const Json*, const char*> meshopt_of(const Json& view);

/// The bytes that a stream stands for: `count` elements of `byteStride` bytes, as the extension says,
/// its filter undone. Sizes are compared with the stream before memory is taken. Throws `IoError` naming
/// `place` where extension or stream is damaged, and `Unsupported` for a later version's.
Bytes decode_meshopt(const Json& extension, ByteView stream, const std::string& place);

}  // namespace mq
