#include "mq/io/detail/gltf_container.h"

#include <cstring>
#include <limits>

#include "mq/base/error.h"

namespace mq {
namespace {

constexpr std::uint32_t json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;

void append_chunk(Bytes& glb, ByteView chunk, std::uint32_t type, char padding) {
  append_raw(glb, std::uint32_t((chunk.size() + 3) / 4 * 4));
  append_raw(glb, type);
  glb.insert(glb.end(), chunk.begin(), chunk.end());
  pad_to_four(glb, padding);
}

}  // namespace

void pad_to_four(Bytes& bytes, char with) {
  while (bytes.size() % 4 != 0) bytes.push_back(std::byte(with));
}

Bytes glb_bytes(ByteView json, ByteView binary, ByteView rest) {
  Bytes bytes = to_bytes("glTF");
  append_raw(bytes, std::uint32_t(2));
  append_raw(bytes, std::uint32_t(0));  // the size, set below
  append_chunk(bytes, json, json_chunk, ' ');
  if (!binary.empty()) append_chunk(bytes, binary, binary_chunk, '\0');
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  if (bytes.size() > std::numeric_limits<std::uint32_t>::max())
    throw Unsupported("a GLB holds at most 4 GB; write .gltf, .ply or .obj");
  const auto size = std::uint32_t(bytes.size());
  std::memcpy(bytes.data() + 8, &size, sizeof size);
  return bytes;
}

}  // namespace mq
