#pragma once
/// Stores of evolving meshes as they were written in version 1 (docs/evolving_format.md).

#include <fmt/format.h>

#include <bit>
#include <filesystem>
#include <span>

#include "mq/io/atomic_file.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/symbol_streams.h"

namespace mq::version_1 {

inline void put(Bytes& bytes, std::uint64_t value) {
  for (; value >= 128; value >>= 7) bytes.push_back(std::byte(value | 128));
  bytes.push_back(std::byte(value));
}

/// Whole numbers, each as the difference from the one before.
template <class Number>
void put_differences(Bytes& bytes, std::span<const Number> numbers, std::size_t stride) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    put(bytes, folded(std::int64_t(numbers[i]) - (i < stride ? 0 : std::int64_t(numbers[i - stride]))));
}

inline std::span<const int> flat(const std::vector<Triangle>& triangles) {
  return {reinterpret_cast<const int*>(triangles.data()), 3 * triangles.size()};
}

inline Bytes segment_block(const EvolvingSegment& segment, const std::vector<std::int64_t>& key) {
  Bytes bytes;
  put(bytes, segment.vertex_ids.size());
  put_differences<int>(bytes, segment.vertex_ids, 1);
  put(bytes, segment.triangle_ids.size());
  put_differences<int>(bytes, segment.triangle_ids, 1);
  put_differences<int>(bytes, flat(segment.triangles), 1);
  put(bytes, segment.uvs.size());
  for (const Vector2& uv : segment.uvs)
    for (const double x : uv) append_raw(bytes, x);
  put(bytes, segment.corner_uvs.size());
  put_differences<int>(bytes, flat(segment.corner_uvs), 1);
  put_differences<std::int64_t>(bytes, key, 3);
  return bytes;
}

inline Bytes frame_block(const std::vector<std::int64_t>& coordinates, const std::vector<std::int64_t>& key) {
  std::vector<std::int64_t> moved(key.size());
  for (std::size_t i = 0; i < key.size(); ++i) moved[i] = coordinates[i] - key[i];
  Bytes bytes;
  put_differences<std::int64_t>(bytes, moved, 3);
  return bytes;
}

/// In steps of 2 to the power of `exponent`.
inline void write_store(const std::filesystem::path& manifest, const EvolvingMesh& evolving, int exponent) {
  const std::filesystem::path blocks = std::filesystem::path(manifest).replace_extension(".blocks");
  std::string lines = fmt::format(
      "{{\"format\":\"marquetry evolving mesh\",\"version\":1,\"blocks\":\"{}\",\"step_exponent\":{},\"about\":"
      "{{\"by\":\"version 1\"}}}}\n",
      blocks.filename().string(), exponent);
  Bytes all;
  const auto append = [&](const Bytes& bytes) {
    const std::string place =
        fmt::format("\"offset\":{},\"bytes\":{},\"crc32\":{}", all.size(), bytes.size(), crc32(bytes));
    all.insert(all.end(), bytes.begin(), bytes.end());
    return place;
  };
  int open = -1;
  std::vector<std::int64_t> key;
  for (const EvolvingFrame& frame : evolving.frames) {
    const std::vector<std::int64_t> coordinates = in_steps(frame.positions, std::exp2(exponent));
    for (; open < frame.segment; ++open) {
      key = coordinates;
      const EvolvingSegment& segment = evolving.segments[std::size_t(open) + 1];
      lines += fmt::format("{{\"segment\":{},\"vertices\":{},\"triangles\":{},{}}}\n", open + 1,
                           segment.vertex_count(), segment.triangle_count(), append(segment_block(segment, key)));
    }
    lines += fmt::format("{{\"frame\":{},\"segment\":{},{},\"measured\":{{\"seen\":{}}}}}\n", frame.number, open,
                         append(frame_block(coordinates, key)), frame.number);
  }
  write_file(blocks, all);
  write_file(manifest, bytes_of(lines));
}

}  // namespace mq::version_1
