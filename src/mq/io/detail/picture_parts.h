#pragma once
/// The segments of a JPEG and the chunks of a PNG, one after the other, before either is decoded.

#include <cstddef>
#include <optional>
#include <string_view>

#include "mq/io/bytes.h"

namespace mq {

/// The number in `width` bytes, the most significant first; bytes beyond the end are 0.
inline std::size_t big_endian(ByteView bytes, std::size_t at, std::size_t width) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < width; ++i)
    value = value << 8 | (at + i < bytes.size() ? std::to_integer<std::size_t>(bytes[at + i]) : 0);
  return value;
}

struct JpegSegment {
  static constexpr unsigned scan = 0xda, end_of_picture = 0xd9;
  unsigned marker = 0;
  std::size_t begin = 0, end = 0;  ///< of its contents; beyond the file, or before the beginning, in one that is damaged
};

/// The next segment from `at` on, which goes to what follows it. As decoders do it passes over what is no marker:
/// coded pixels, filling, loose bytes. Nothing where the file ends before.
inline std::optional<JpegSegment> next_segment(ByteView jpeg, std::size_t& at) {
  while (at + 1 < jpeg.size()) {
    const auto marker = unsigned(jpeg[at] == std::byte(0xff) ? big_endian(jpeg, at + 1, 1) : 0);
    const bool alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (marker == JpegSegment::end_of_picture) return JpegSegment{marker, at + 2, at + 2};
    if (marker == 0x00 || marker == 0xff || alone) {
      at += alone ? 2 : 1;
      continue;
    }
    if (at + 3 >= jpeg.size()) return {};
    const std::size_t begin = at + 4;
    at += 2 + big_endian(jpeg, at + 2, 2);
    return JpegSegment{marker, begin, at};
  }
  return {};
}

struct PngChunk {
  std::string_view type;
  ByteView contents;
};

/// The chunk at `at`, which goes to the one after it. Nothing where it does not lie in the file.
inline std::optional<PngChunk> next_chunk(ByteView png, std::size_t& at) {
  constexpr std::size_t frame = 12;  // length, type and check
  if (at > png.size() || png.size() - at < frame) return {};
  const std::size_t length = big_endian(png, at, 4);
  if (png.size() - at - frame < length) return {};
  const PngChunk chunk{text_of(png.subspan(at + 4, 4)), png.subspan(at + 8, length)};
  at += frame + length;
  return chunk;
}
inline constexpr std::size_t first_png_chunk = 8, first_jpeg_segment = 2;

}  // namespace mq
