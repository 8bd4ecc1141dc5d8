#include <gtest/gtest.h>

#include <cmath>

#include "io/evolving_strip.h"
#include "io/evolving_version_1.h"
#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_motion.h"
#include "mq/io/detail/symbol_streams.h"

namespace mq {
namespace {

TEST(EvolvingBlocks, HaveTheChecksumOfTheStandard) {
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926U);
}

template <class Decode>
void expect_refuses_random_bytes(const Decode& decode) {
  const Random random(1);
  std::uint64_t draw = 0;
  int refused = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes(std::size_t(64 * random.uniform(draw++)));
    for (std::byte& byte : bytes) byte = std::byte(int(256 * random.uniform(draw++)));
    try {
      decode(bytes);
    } catch (const IoError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1900);
}

/// Blocks with some bytes changed, and cut anywhere.
template <class Decode>
void expect_refuses_changes(const Bytes& sound, const Decode& decode) {
  const Random random(2);
  std::uint64_t draw = 0;
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = sound;
    for (int change = 0; change < 1 + round % 3; ++change) spoil(bytes, random, draw);
    try {
      decode(bytes);
    } catch (const IoError&) {
    }
  }
  std::size_t whole = sound.size();
  while (whole > 0 && sound[whole - 1] == std::byte(0)) --whole;
  for (std::size_t size = 0; size < whole; ++size) EXPECT_THROW(decode(ByteView(sound).first(size)), IoError) << size;
}

void decode_old_segment(ByteView bytes) { check(decode_segment(bytes, "noise").segment); }
void decode_whole(ByteView bytes) { check(decode_change(bytes, {}, "noise")); }

TEST(EvolvingBlocks, OfASegmentRefuseRandomBytes) {
  expect_refuses_random_bytes(decode_old_segment);
  expect_refuses_random_bytes(decode_whole);
}

TEST(EvolvingBlocks, OfVersion1WithChangedBytesAreRefusedOrSayASegment) {
  const EvolvingMesh strip = stored_strip(5, 2);
  expect_refuses_changes(
      version_1::segment_block(strip.segments[0], in_steps(strip.frames[0].positions, test_step)), decode_old_segment);
}

TEST(EvolvingBlocks, WithChangedBytesAreRefusedOrSayASegment) {
  const EvolvingMesh strip = stored_strip(300, 2);
  expect_refuses_changes(encode_change(strip.segments[0], {}, 0), decode_whole);
  expect_refuses_changes(encode_change(strip.segments[0], {}, 0x1p-16), decode_whole);
  expect_refuses_changes(encode_change(strip.segments[1], strip.segments[0], 0),
                         [&](ByteView bytes) { check(decode_change(bytes, strip.segments[0], "noise")); });
}

TEST(EvolvingBlocks, OfAFrameWithChangedBytesAreRefusedOrSayPositions) {
  const EvolvingMesh strip = stored_strip(300, 2);
  const CodingOrder order(strip.segments[0].triangles, strip.segments[0].vertex_count());
  MotionState motion;
  for (const EvolvingFrame& frame : strip.frames) {
    const std::vector<std::int64_t> coordinates = in_steps(frame.positions, test_step);
    const Bytes sound = encode_positions(coordinates, order, motion);
    EXPECT_EQ(decode_positions(sound, order, motion, "frame"), coordinates);
    expect_refuses_changes(sound, [&](ByteView bytes) { (void)decode_positions(bytes, order, motion, "noise"); });
    motion.advance(coordinates);
  }
}

TEST(EvolvingBlocks, OfCoordinatesFarApartComeBack) {
  const CodingOrder order({{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}, 5);
  const Random random(4);
  MotionState motion;
  for (std::uint64_t frame = 0; frame < 4; ++frame) {
    std::vector<std::int64_t> coordinates;
    for (std::uint64_t i = 0; i < 15; ++i)
      coordinates.push_back(std::llround((random.uniform(15 * frame + i) - 0.5) * 0x1p51));
    EXPECT_EQ(decode_positions(encode_positions(coordinates, order, motion), order, motion, "frame"), coordinates);
    motion.advance(coordinates);
  }
}

/// Streams of each coding. Those of zstd were written for some days; this one is of `zstd -19`, sixty-four times 1.
TEST(EvolvingBlocks, HaveStreamsOfEachCoding) {
  const Random random(6);
  for (const int kinds : {1, 2, 12, 100}) {
    SymbolWriter to(2);
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t i = 0; i < 3000; ++i)
      numbers.push_back(std::uint64_t(kinds * random.uniform(kinds == 2 ? i % 50 : i)));
    for (const std::uint64_t number : numbers) to.put(1, number);
    const Bytes bytes = to.bytes();
    EXPECT_EQ(std::to_integer<int>(bytes[3]), kinds == 1 ? 0 : kinds == 2 ? 3 : 1) << kinds;
    SymbolReader from(bytes, 2, 3000, "streams");
    for (const std::uint64_t number : numbers) EXPECT_EQ(from.get(1), number);
    from.end();
  }
  Bytes bytes;
  for (const int byte : {64, 2, 16, 40, 181, 47, 253, 0, 104, 61, 0, 0, 8, 1, 1, 0, 148, 128, 16, 0})
    bytes.push_back(std::byte(byte));
  SymbolReader from(bytes, 1, 64, "a stream of zstd");
  for (int i = 0; i < 64; ++i) EXPECT_EQ(from.get(0), 1U);
  EXPECT_THROW(SymbolReader(ByteView(bytes).first(bytes.size() - 2), 1, 64, "a cut one"), IoError);
}

/// What a block says it holds is bounded by its size, before it is made.
TEST(EvolvingBlocks, ThatWouldUnpackToMuchMoreAreRefused) {
  SymbolWriter to(48);
  for (int count = 0; count < 3; ++count) to.put(0, 1 << 24);
  to.put(0, 0);
  for (int id = 0; id < 1 << 20; ++id) to.put(1, 0);
  const Bytes bomb = to.bytes();
  EXPECT_LT(bomb.size(), 100U);
  EXPECT_THROW(decode_whole(bomb), IoError);
  EXPECT_THROW(SymbolReader(bomb, 48, 1 << 20, "bomb"), IoError);
  const SymbolReader roomy(bomb, 48, (1 << 20) + 4, "no bomb");
}

TEST(EvolvingBlocks, OfLargeRegularMeshesAreLargeEnoughForWhatTheyHold) {
  const EvolvingMesh strip = stored_strip(4000, 1);
  const Bytes bytes = encode_change(strip.segments[0], {}, 0x1p-10);
  const EvolvingSegment found = decode_change(bytes, {}, "strip");
  EXPECT_EQ(found.triangles, strip.segments[0].triangles);
  EXPECT_GE(most_added_per_byte * std::ssize(bytes),
            found.vertex_count() + found.triangle_count() + std::ssize(found.uvs));
}

}  // namespace
}  // namespace mq
