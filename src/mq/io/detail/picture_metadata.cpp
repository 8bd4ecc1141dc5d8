// A profile that is damaged keeps its place in JPEG and TIFF under a name that nobody knows; in PNG its chunk goes.

#include "mq/io/detail/picture_metadata.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>

#include "mq/io/detail/picture_parts.h"
#include "mq/io/detail/tiff_bytes.h"

namespace mq {
namespace {

using namespace std::string_view_literals;

constexpr const char* colour_profile = "colour profile";

bool holds(ByteView bytes, std::size_t at, std::string_view text) {
  return bytes.size() >= at && bytes.size() - at >= text.size() &&
         std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

/// Text in several languages: each record's letters lie in the tag.
bool is_sound_text(ByteView tag) {
  constexpr std::size_t head = 16, record = 12;
  const std::size_t records = big_endian(tag, 8, 4);
  if (tag.size() < head || big_endian(tag, 12, 4) != record || records > (tag.size() - head) / record) return false;
  for (std::size_t r = 0; r < records; ++r) {
    const std::size_t size = big_endian(tag, head + r * record + 4, 4), at = big_endian(tag, head + r * record + 8, 4);
    if (at > tag.size() || size > tag.size() - at) return false;
  }
  return true;
}

/// A JPEG's segments before its pixels.
std::vector<JpegSegment> segments_of(ByteView jpeg) {
  std::vector<JpegSegment> segments;
  std::size_t at = first_jpeg_segment;
  while (const std::optional<JpegSegment> segment = next_segment(jpeg, at)) {
    if (segment->marker == JpegSegment::scan || segment->marker == JpegSegment::end_of_picture) break;
    if (segment->begin <= segment->end && segment->end <= jpeg.size()) segments.push_back(*segment);
  }
  return segments;
}

/// A profile lies in pieces that say which they are and how many there are.
SoundPicture sound_jpeg(ByteView jpeg) {
  constexpr unsigned app2 = 0xe2;
  constexpr auto mark = "ICC_PROFILE\0"sv;
  std::vector<std::size_t> pieces;
  Bytes profile;
  bool sound = true;
  for (const JpegSegment& segment : segments_of(jpeg)) {
    if (segment.marker != app2 || !holds(jpeg.first(segment.end), segment.begin, mark)) continue;
    pieces.push_back(segment.begin);
    const std::size_t content = segment.begin + mark.size() + 2;
    sound = sound && content <= segment.end && big_endian(jpeg, content - 2, 1) == pieces.size();
    if (sound) profile.insert(profile.end(), jpeg.begin() + std::ptrdiff_t(content), jpeg.begin() + std::ptrdiff_t(segment.end));
  }
  for (const std::size_t piece : pieces) sound = sound && big_endian(jpeg, piece + mark.size() + 1, 1) == pieces.size();
  if (pieces.empty() || (sound && is_sound_profile(profile))) return {};
  SoundPicture result{{jpeg.begin(), jpeg.end()}, {colour_profile}};
  for (const std::size_t piece : pieces) result.changed[piece] = std::byte('-');
  return result;
}

SoundPicture sound_tiff(ByteView bytes) {
  constexpr unsigned icc_profile = 34675, byte = 1, undefined = 7, unknown = icc_profile - 1;
  const TiffBytes tiff(bytes);
  const auto entries = first_directory(tiff);
  SoundPicture result;
  if (!entries) return result;
  for (const TiffEntry& entry : *entries) {
    if (entry.tag != icc_profile) continue;
    const bool inside = (entry.type == byte || entry.type == undefined) && entry.values <= tiff.size() &&
                        entry.count <= tiff.size() - entry.values;
    if (inside && is_sound_profile(bytes.subspan(entry.values, entry.count))) continue;
    if (result.changed.empty()) result = {{bytes.begin(), bytes.end()}, {colour_profile}};
    result.changed[entry.place + (tiff.is_big_endian() ? 1 : 0)] = std::byte(unknown & 0xff);
    result.changed[entry.place + (tiff.is_big_endian() ? 0 : 1)] = std::byte(unknown >> 8);
  }
  return result;
}

/// What was deflated; nothing where that is damaged, or more than any profile is.
std::optional<Bytes> inflated(ByteView deflated) {
  constexpr uLong most = 1 << 24;
  for (uLong size = 1 << 16; size <= most; size *= 4) {
    Bytes found(size);
    uLongf length = size;
    const int result = ::uncompress(reinterpret_cast<Bytef*>(found.data()), &length,
                                    reinterpret_cast<const Bytef*>(deflated.data()), uLong(deflated.size()));
    if (result == Z_BUF_ERROR) continue;
    if (result != Z_OK) return {};
    found.resize(length);
    return found;
  }
  return {};
}

/// Whether the contents of a chunk iCCP, a name, a 0, a 0 and what was deflated, are a profile.
bool is_sound_chunk(ByteView chunk) {
  constexpr std::ptrdiff_t longest_name = 79;
  const auto name_end = std::find(chunk.begin(), chunk.end(), std::byte(0));
  if (name_end - chunk.begin() > longest_name || chunk.end() - name_end < 2) return false;
  const std::optional<Bytes> profile = inflated(chunk.subspan(std::size_t(name_end - chunk.begin()) + 2));
  return profile && is_sound_profile(*profile);
}

SoundPicture sound_png(ByteView png) {
  SoundPicture result;
  std::size_t kept = 0;
  const auto keep_to = [&](std::size_t end) {
    result.changed.insert(result.changed.end(), png.begin() + std::ptrdiff_t(kept), png.begin() + std::ptrdiff_t(end));
  };
  std::size_t begin = first_png_chunk, at = begin;
  for (; const std::optional<PngChunk> chunk = next_chunk(png, at); begin = at) {
    if (chunk->type != "iCCP" || is_sound_chunk(chunk->contents)) continue;
    keep_to(begin);
    kept = at;
    result.left_out = {colour_profile};
  }
  if (kept > 0) keep_to(png.size());
  return result;
}

bool states_colour(std::string_view type) {
  static constexpr std::string_view types[] = {"cICP", "iCCP", "sRGB", "gAMA", "cHRM"};
  return std::ranges::count(types, type) > 0;
}

/// What OpenImageIO adds: an offset of 0, and texts of what it calls colour spaces.
bool says_nothing(const PngChunk& chunk) {
  if (chunk.type == "tEXt") return holds(chunk.contents, 0, "oiio:"sv);
  return chunk.type == "oFFs" && std::ranges::all_of(chunk.contents, [](std::byte b) { return b == std::byte(0); });
}

}  // namespace

Bytes png_colour_chunks(ByteView png) {
  Bytes found;
  std::size_t begin = first_png_chunk, at = begin;
  for (; const std::optional<PngChunk> chunk = next_chunk(png, at); begin = at)
    if (states_colour(chunk->type)) found.insert(found.end(), &png[begin], &png[begin] + (at - begin));
  return found;
}

Bytes with_png_colour(ByteView png, ByteView chunks) {
  Bytes result(png.begin(), png.begin() + first_png_chunk);
  std::size_t begin = first_png_chunk, at = begin;
  for (; const std::optional<PngChunk> chunk = next_chunk(png, at); begin = at) {
    if (says_nothing(*chunk) || (!chunks.empty() && states_colour(chunk->type))) continue;
    result.insert(result.end(), &png[begin], &png[begin] + (at - begin));
    if (chunk->type == "IHDR") result.insert(result.end(), chunks.begin(), chunks.end());
  }
  return result;
}

bool is_sound_profile(ByteView profile) {
  constexpr std::size_t head = 128, entry = 12, least_tag = 12;
  if (profile.size() < head + 4 || !holds(profile, 36, "acsp"sv)) return false;
  const std::size_t tags = big_endian(profile, head, 4);
  if (tags > (profile.size() - head - 4) / entry) return false;
  for (std::size_t i = 0; i < tags; ++i) {
    const std::size_t place = head + 4 + i * entry;
    const std::size_t at = big_endian(profile, place + 4, 4), size = big_endian(profile, place + 8, 4);
    if (at > profile.size() || size > profile.size() - at || size < least_tag) return false;
    if (holds(profile, at, "mluc"sv) && !is_sound_text(profile.subspan(at, size))) return false;
  }
  return true;
}

SoundPicture without_damaged_metadata(ByteView bytes, const std::string& file_format) {
  if (file_format == "jpeg") return sound_jpeg(bytes);
  if (file_format == "tiff") return sound_tiff(bytes);
  if (file_format == "png") return sound_png(bytes);
  return {};
}

}  // namespace mq
