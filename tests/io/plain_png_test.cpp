#include "mq/io/detail/plain_png.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <utility>

#include "io/folder.h"
#include "io/picture_bytes.h"
#include "mq/io/detail/picture_codec.h"
#include "mq/io/detail/png_strips.h"

using namespace mq;

namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Values that all filters, borders and byte orders leave traces in; some beyond 0 and 1.
Texture pattern(int channels, Depth depth, int width = 37, int height = 21) {
  Texture texture;
  texture.pixels = Image<float>(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        texture.pixels(x, y, c) = float((x * x * 7 + y * 13 * (c + 1) + x * y) % 300 - 10) / 280.0F;
  texture.format.depth = depth;
  return texture;
}

}  // namespace

// What is written here is read there to the same bits, and what is written there is read here.
TEST(PlainPng, IsWhatOpenImageIoReadsAndWrites) {
  for (const int channels : {1, 2, 3, 4})
    for (const Depth depth : {Depth::u8, Depth::u16}) {
      const Texture texture = pattern(channels, depth);
      const EncodedPicture here = plain_png_bytes(texture, "p", format_named("png"), {});
      const EncodedPicture there = picture_codec().encode(texture, "p", "png", {});
      EXPECT_EQ(here.notes, there.notes);
      for (const auto& encoded : {here.bytes, there.bytes}) {
        const auto plain = read_plain_png(encoded, {});
        ASSERT_TRUE(plain.has_value()) << channels;
        const Texture read = picture_codec().read(encoded, "p", {}, NotFinite::refuse, "");
        EXPECT_EQ(plain->format.depth, read.format.depth);
        EXPECT_TRUE(std::ranges::equal(plain->pixels.values(), read.pixels.values())) << channels;
        const auto info = plain_png_info(encoded);
        EXPECT_EQ(info->channels, picture_codec().info(encoded, "p").channels);
        EXPECT_EQ(info->width, 37);
        EXPECT_EQ(info->height, 21);
      }
    }
}

// Pictures of several strips, of rows shorter than what deflate looks back to, and of one row in a strip.
TEST(PlainPng, OfManyStripsIsReadByOthers) {
  for (const auto& [width, height] : {std::pair(611, 1500), std::pair(1, 32768), std::pair(32768, 5)}) {
    const Texture texture = pattern(4, Depth::u16, width, height);
    const EncodedPicture encoded = plain_png_bytes(texture, "p", format_named("png"), {});
    const auto plain = read_plain_png(encoded.bytes, {});
    ASSERT_TRUE(plain.has_value()) << width;
    for (std::size_t i = 0; i < texture.pixels.values().size(); ++i)
      ASSERT_NEAR(plain->pixels.values()[i], std::clamp(texture.pixels.values()[i], 0.0F, 1.0F), 0.501 / 65535) << i;
    const Texture read = picture_codec().read(encoded.bytes, "p", {}, NotFinite::refuse, "");
    EXPECT_TRUE(std::ranges::equal(plain->pixels.values(), read.pixels.values())) << width;
  }
}

// Strips are one stream whose check sum zlib confirms, and as small, to half a hundredth, as if it had not been cut.
TEST(PngStrips, AreOneStreamAsSmallAsIfItWereNotCut) {
  constexpr int width = 1200, height = 1400, level = 4;
  const auto row = [](int y, std::uint8_t* to) {
    for (int x = 0; x < width; ++x) to[x] = std::uint8_t((x / 7 * y / 11 + (x * y) % 5) & 255);
  };
  const PngStrips strips(height, width, 1, level, Z_FILTERED);
  ASSERT_GT(strips.count(), 2);
  std::vector<std::uint8_t> stream;
  std::uint32_t sum = 1;
  for (int s = 0; s < strips.count(); ++s) {
    const PngStrips::Strip strip = strips.compress(s, row);
    stream.insert(stream.end(), strip.bytes.begin(), strip.bytes.end());
    sum = PngStrips::sum(sum, strip);
  }
  for (const int shift : {24, 16, 8, 0}) stream.push_back(std::uint8_t(sum >> shift));

  std::vector<std::uint8_t> rows((width + 1) * height);
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(rows.data(), &size, stream.data(), stream.size()), Z_OK);
  ASSERT_EQ(size, rows.size());
  z_stream whole{};
  ASSERT_EQ(deflateInit2(&whole, level, Z_DEFLATED, 15, 8, Z_FILTERED), Z_OK);
  std::vector<std::uint8_t> room(deflateBound(&whole, rows.size()));
  whole.next_in = rows.data(), whole.avail_in = uInt(rows.size());
  whole.next_out = room.data(), whole.avail_out = uInt(room.size());
  EXPECT_EQ(deflate(&whole, Z_FINISH), Z_STREAM_END);
  EXPECT_LT(double(stream.size()), 1.005 * double(whole.total_out));
  deflateEnd(&whole);
}

TEST(PlainPng, TakesEveryFilterOff) {
  std::string rows;
  for (int y = 0; y < 6; ++y) {
    rows += char(y == 5 ? 4 : y);
    for (int i = 0; i < 12; ++i) rows += char((i * 37 + y * 101 + i * i * y) & 255);
  }
  const std::string file = test::png_file({4, 6, 8, 2}, rows);
  const auto plain = read_plain_png(bytes_of(file), {});
  ASSERT_TRUE(plain.has_value());
  const Texture read = picture_codec().read(bytes_of(file), "p", {}, NotFinite::refuse, "");
  EXPECT_TRUE(std::ranges::equal(plain->pixels.values(), read.pixels.values()));
}

TEST(PlainPng, LeavesAllOthersAlone) {
  const std::string row("\0\x01\x80\xfe", 4);
  EXPECT_TRUE(read_plain_png(bytes_of(test::png_file({3, 1, 8, 0}, row)), {}));
  for (const std::string& file :
       {std::string(), std::string("v 0 0 0\n"), test::png_file({3, 1, 8, 3}, row),
        test::png_file({3, 1, 8, 0, 1}, row), test::png_file({24, 1, 1, 0}, row),
        test::png_file({3, 1, 8, 0}, row, test::png_chunk("gAMA", test::big_endian(100000))),
        test::png_file({3, 1, 8, 0}, row, test::png_chunk("oFFs", std::string(7, 0) + "\x01\x01"))})
    EXPECT_FALSE(read_plain_png(bytes_of(file), {})) << file.size();
}

// Wherever a file is cut or a byte of it is another one, it is not read here, or holds the same values.
TEST(PlainPng, LeavesDamagedOnesAlone) {
  const Texture texture = pattern(3, Depth::u8);
  const EncodedPicture encoded = plain_png_bytes(texture, "p", format_named("png"), {});
  const auto whole = read_plain_png(encoded.bytes, {});
  for (std::size_t cut = 0; cut < encoded.bytes.size(); cut += 7)
    EXPECT_FALSE(read_plain_png(std::span(encoded.bytes).first(cut), {})) << cut;
  for (std::size_t at = 0; at < encoded.bytes.size(); at += 3) {
    std::vector<std::byte> other = encoded.bytes;
    other[at] ^= std::byte(0x10);
    EXPECT_FALSE(read_plain_png(other, {})) << at;
  }
  // Rows that are missing, rows that are too many, a filter that there is none of.
  EXPECT_TRUE(read_plain_png(bytes_of(test::png_file({1, 2, 8, 0}, std::string(4, 0))), {}));
  for (const std::string& rows : {std::string(2, 0), std::string(6, 0), std::string("\x05\0\0\0", 4)})
    EXPECT_FALSE(read_plain_png(bytes_of(test::png_file({1, 2, 8, 0}, rows)), {})) << rows.size();
}
