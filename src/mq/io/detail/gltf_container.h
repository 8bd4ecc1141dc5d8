#pragma once
/// The bytes of a GLB: a header, a chunk of JSON and a binary chunk, each a multiple of four long.

#include "mq/io/bytes.h"

namespace mq {

/// Appends `with` until the size is a multiple of four.
void pad_to_four(Bytes& bytes, char with);

/// A GLB of JSON, a binary chunk unless it is empty, and what follows them in another GLB.
/// Throws `Unsupported` beyond 4 GB.
Bytes glb_bytes(ByteView json, ByteView binary, ByteView rest);

}  // namespace mq
