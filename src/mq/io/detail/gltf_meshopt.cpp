// A stream begins with a byte that says codec and version: 0xa0 vertices, 0xe0 or 0xe1 triangles, 0xd0
// or 0xd1 indices. Vertices cost at least a byte for 64 of their bytes, indices a byte for a triangle.
#include "mq/io/detail/gltf_meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The most bytes that a byte of a stream can stand for, with some to spare for its first and last.
constexpr std::size_t meshopt_expansion = 128, meshopt_spare = 4096;

[[noreturn]] void fail_meshopt(const std::string& place, const std::string& what) {
  throw IoError(fmt::format("{}: compressed by meshopt, and {}; the file may be damaged: export it again",
                            place, what));
}

struct MeshoptStream {
  std::string mode;
  std::string filter;
  std::size_t count = 0;
  std::size_t stride = 0;
};

MeshoptStream stream_of(const Json& extension, const std::string& place) {
  MeshoptStream s;
  s.mode = json_text_of(extension, "mode");
  s.filter = json_text_of(extension, "filter");
  if (s.filter.empty()) s.filter = "NONE";
  s.count = std::size_t(json_count(extension, "count", 0, place));
  s.stride = std::size_t(json_count(extension, "byteStride", 0, place));
  const bool vertices = s.mode == "ATTRIBUTES";
  if (!vertices && s.mode != "TRIANGLES" && s.mode != "INDICES")
    fail_meshopt(place, fmt::format("its mode {} is none of ATTRIBUTES, TRIANGLES and INDICES",
                                    shown(s.mode)));
  const bool stride_fits = vertices ? s.stride > 0 && s.stride <= 256 && s.stride % 4 == 0
                                    : s.stride == 2 || s.stride == 4;
  if (!stride_fits) fail_meshopt(place, fmt::format("elements have {} bytes", s.stride));
  if (s.mode == "TRIANGLES" && s.count % 3 != 0)
    fail_meshopt(place, fmt::format("{} corners do not make triangles of three each", s.count));
  return s;
}

void undo_filter(const MeshoptStream& s, Bytes& bytes, const std::string& place) {
  if (s.filter == "NONE") return;
  if (s.filter == "COLOR")
    throw Unsupported(fmt::format("{}: meshopt's filter COLOR, which is of a later version than can be "
                                  "read; compress it as EXT_meshopt_compression",
                                  place));
  const bool oct = s.filter == "OCTAHEDRAL", turn = s.filter == "QUATERNION";
  if (!oct && !turn && s.filter != "EXPONENTIAL")
    fail_meshopt(place, fmt::format("its filter {} is none of OCTAHEDRAL, QUATERNION and EXPONENTIAL",
                                    shown(s.filter)));
  if (s.mode != "ATTRIBUTES" || (oct && s.stride != 4 && s.stride != 8) || (turn && s.stride != 8))
    fail_meshopt(place, fmt::format("its filter {} does not fit its elements", s.filter));
  if (s.count == 0) return;
  if (oct) meshopt_decodeFilterOct(bytes.data(), s.count, s.stride);
  if (turn) meshopt_decodeFilterQuat(bytes.data(), s.count, s.stride);
  if (!oct && !turn) meshopt_decodeFilterExp(bytes.data(), s.count, s.stride);
}

}  // namespace

std::pair<const Json*, const char*> meshopt_of(const Json& view) {
  if (const Json* extensions = json_object(view, "extensions"))
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
      if (const Json* extension = json_object(*extensions, name)) return {extension, name};
  return {nullptr, nullptr};
}

Bytes decode_meshopt(const Json& extension, ByteView stream, const std::string& place) {
  const MeshoptStream s = stream_of(extension, place);
  if (s.count > (stream.size() * meshopt_expansion + meshopt_spare) / s.stride)
    fail_meshopt(place, fmt::format("{} bytes cannot hold {} elements of {}", stream.size(), s.count,
                                    s.stride));
  const auto* from = reinterpret_cast<const unsigned char*>(stream.data());
  const bool vertices = s.mode == "ATTRIBUTES", triangles = s.mode == "TRIANGLES";
  const unsigned head = stream.empty() ? 0 : from[0];
  const unsigned known = vertices ? 0xa0 : triangles ? 0xe1 : 0xd1;
  if ((head & 0xf0) == (known & 0xf0) && head > known)
    throw Unsupported(fmt::format("{}: compressed by a later version of meshopt than can be read; "
                                  "compress it as EXT_meshopt_compression",
                                  place));
  Bytes bytes(s.count * s.stride);
  const int failed =
      vertices ? meshopt_decodeVertexBuffer(bytes.data(), s.count, s.stride, from, stream.size())
      : triangles
          ? meshopt_decodeIndexBuffer(bytes.data(), s.count, s.stride, from, stream.size())
          : meshopt_decodeIndexSequence(bytes.data(), s.count, s.stride, from, stream.size());
  if (failed != 0)
    fail_meshopt(place, failed == -1 ? "its stream begins as none of this mode does"
                                     : "its stream is cut short or has bytes too many");
  undo_filter(s, bytes, place);
  return bytes;
}

}  // namespace mq
