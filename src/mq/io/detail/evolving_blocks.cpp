#include "mq/io/detail/evolving_blocks.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/io/detail/symbol_streams.h"

namespace mq {
namespace {

class Decoder {
 public:
  Decoder(ByteView bytes, const std::string& what) : bytes_(bytes), what_(what) {}

  std::uint64_t number() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (at_ == bytes_.size()) fail("ends too early");
      const auto byte = std::to_integer<std::uint64_t>(bytes_[at_++]);
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
    fail("holds a number of more than 64 bits");
  }

  /// How many of something follow, of at least `bytes` bytes each.
  std::size_t count(std::size_t bytes) {
    const std::uint64_t value = number();
    if (value > (bytes_.size() - at_) / bytes) fail("ends too early");
    return std::size_t(value);
  }

  int difference(int before) {
    const std::int64_t value =
        std::int64_t(std::uint64_t(before) + std::uint64_t(unfolded(number())));
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max())
      fail("holds an index out of range");
    return int(value);
  }

  std::vector<int> ids(std::size_t count) {
    std::vector<int> all(count);
    int before = 0;
    for (int& id : all) before = id = difference(before);
    return all;
  }

  std::vector<Triangle> triangles(std::size_t count) {
    std::vector<Triangle> all(count);
    int before = 0;
    for (Triangle& t : all)
      for (int& index : t) before = index = difference(before);
    return all;
  }

  std::vector<std::int64_t> coordinates(std::size_t count) {
    std::vector<std::int64_t> all(count);
    for (std::size_t i = 0; i < count; ++i)
      all[i] =
          std::int64_t(std::uint64_t(unfolded(number())) + (i < 3 ? 0 : std::uint64_t(all[i - 3])));
    return all;
  }

  double real() {
    if (bytes_.size() - at_ < 8) fail("ends too early");
    std::uint64_t bits = 0;
    for (int k = 0; k < 8; ++k) bits |= std::to_integer<std::uint64_t>(bytes_[at_++]) << 8 * k;
    return std::bit_cast<double>(bits);
  }

  void end() {
    if (at_ != bytes_.size()) fail("goes on after its end");
  }

  [[noreturn]] void fail(const std::string& found) const {
    throw IoError(
        fmt::format("{} {}; use frames that do not need it, or make it again", what_, found));
  }

 private:
  ByteView bytes_;
  std::string what_;
  std::size_t at_ = 0;
};

}  // namespace

std::uint32_t crc32(ByteView bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> rows{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      rows[i] = i;
      for (int bit = 0; bit < 8; ++bit)
        rows[i] = rows[i] & 1 ? 0xEDB88320U ^ (rows[i] >> 1) : rows[i] >> 1;
    }
    return rows;
  }();
  std::uint32_t sum = ~0U;
  for (const std::byte byte : bytes)
    sum = table[(sum ^ std::to_integer<std::uint32_t>(byte)) & 255] ^ (sum >> 8);
  return ~sum;
}

std::vector<std::int64_t> in_steps(const std::vector<Vector3>& positions, double step) {
  std::vector<std::int64_t> all;
  all.reserve(3 * positions.size());
  for (const Vector3& p : positions)
    for (const double x : p) {
      if (!(std::abs(x / step) <= 0x1p50))
        throw InvalidInput(
            fmt::format("a position of {} cannot be stored in steps of {}", x, step));
      all.push_back(std::llround(x / step));
    }
  return all;
}

std::vector<Vector3> from_steps(const std::vector<std::int64_t>& coordinates, double step) {
  std::vector<Vector3> all(coordinates.size() / 3);
  for (std::size_t v = 0; v < all.size(); ++v)
    for (int k = 0; k < 3; ++k) all[v][k] = double(coordinates[3 * v + k]) * step;
  return all;
}

SegmentBlock decode_segment(ByteView bytes, const std::string& what) {
  Decoder from(bytes, what);
  SegmentBlock block;
  EvolvingSegment& segment = block.segment;
  segment.vertex_ids = from.ids(from.count(4));
  const std::size_t triangles = from.count(4);
  segment.triangle_ids = from.ids(triangles);
  segment.triangles = from.triangles(triangles);
  segment.uvs.resize(from.count(16));
  for (Vector2& uv : segment.uvs)
    for (double& x : uv) x = from.real();
  segment.corner_uvs = from.triangles(from.count(3));
  block.key = from.coordinates(3 * segment.vertex_ids.size());
  from.end();
  try {
    check(segment);
  } catch (const InvalidInput& error) {
    from.fail(fmt::format("says nothing sensible: {}", error.what()));
  }
  return block;
}

std::vector<std::int64_t> decode_frame(ByteView bytes, const std::vector<std::int64_t>& key,
                                       const std::string& what) {
  Decoder from(bytes, what);
  std::vector<std::int64_t> all = from.coordinates(key.size());
  from.end();
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = std::int64_t(std::uint64_t(all[i]) + std::uint64_t(key[i]));
  return all;
}

}  // namespace mq
