#include "mq/io/picture_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_parts.h"
#include "mq/io/detail/tiff_bytes.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

bool starts_with(ByteView bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

/// A list of integers that a TIFF directory names: strip offsets and the like.
struct TiffList {
  std::uint64_t count = 0, at = 0;
  unsigned width = 0;
};

/// The lists with these two tags in the first directory; nothing where it lies outside the file.
std::optional<std::array<TiffList, 2>> tiff_lists(const TiffBytes& tiff,
                                                  std::array<std::uint64_t, 2> first_tags,
                                                  std::array<std::uint64_t, 2> second_tags) {
  const auto entries = first_directory(tiff);
  if (!entries) return {};
  std::array<TiffList, 2> lists;
  for (const TiffEntry& entry : *entries) {
    const bool first = std::ranges::count(first_tags, entry.tag) > 0;
    if (!first && std::ranges::count(second_tags, entry.tag) == 0) continue;
    const bool are_integers = entry.type == 3 || entry.type == 4 || entry.type == 16;
    if (!are_integers || entry.count > tiff.size()) return {};
    lists[first ? 0 : 1] = {entry.count, entry.values, entry.width};
  }
  return lists;
}

}  // namespace

void fail_picture(const std::string& name, const std::string& what) {
  throw IoError(fmt::format("{}: {}", name, what));
}

void fail_too_large(const std::string& name, std::int64_t width, std::int64_t height) {
  fail_picture(
      name, fmt::format("{} x {} pixels; at most {} a side can be used: scale it down or cut it in "
                        "several textures",
                        width, height, max_picture_side));
}

std::string picture_format(ByteView bytes, const std::string& name) {
  using namespace std::string_view_literals;
  if (bytes.empty()) fail_picture(name, "the file is empty; a picture was expected");
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n"sv)) return "png";
  if (starts_with(bytes, "\xff\xd8\xff"sv)) return "jpeg";
  if (starts_with(bytes, "II*\0"sv) || starts_with(bytes, "MM\0*"sv) ||
      starts_with(bytes, "II+\0"sv) || starts_with(bytes, "MM\0+"sv))
    return "tiff";
  if (starts_with(bytes, "v/1\x01"sv)) return "openexr";
  if (starts_with(bytes, "RIFF"sv) && bytes.size() >= 12 && starts_with(bytes.subspan(8), "WEBP"sv))
    return "webp";
  if (starts_with(bytes, "\xabKTX 20\xbb\r\n\x1a\n"sv) || starts_with(bytes, "\xabKTX 11\xbb\r\n\x1a\n"sv))
    fail_picture(name, "a KTX container, which cannot be read: its pixels are coded for graphics cards (Basis "
                       "Universal or block compression); take the picture it was made from, or decode it to "
                       "PNG, as ktx of KTX-Software does: ktx extract IN.ktx2 OUT.png");
  if (starts_with(bytes, "BM"sv)) return "bmp";
  if (lower_extension(name) == ".tga") return "targa";
  fail_picture(
      name, fmt::format("not a picture this program reads (its first bytes are of another kind); "
                        "{} are read",
                        known_picture_formats));
}

bool png_states_colour(ByteView bytes, const std::string& name) {
  bool colour = false;
  std::size_t at = first_png_chunk;
  while (const std::optional<PngChunk> chunk = next_chunk(bytes, at)) {
    if (chunk->type == "IEND") return colour;
    colour = colour || chunk->type == "sRGB" || chunk->type == "gAMA" || chunk->type == "iCCP";
  }
  fail_picture(name,
               fmt::format("the PNG file is cut short at {} bytes; copy it again", bytes.size()));
}

void check_jpeg_end(ByteView bytes, const std::string& name) {
  std::size_t at = first_jpeg_segment;
  while (const std::optional<JpegSegment> segment = next_segment(bytes, at))
    if (segment->marker == JpegSegment::end_of_picture) return;
  fail_picture(name,
               fmt::format("the JPEG file is cut short at {} bytes; copy it again", bytes.size()));
}

void check_tiff_extent(ByteView bytes, const std::string& name) {
  const TiffBytes tiff(bytes);
  const auto lists = tiff_lists(tiff, {273, 324}, {279, 325});  // strips, tiles: offsets and sizes
  bool whole = lists.has_value();
  for (std::uint64_t i = 0; whole && i < (*lists)[0].count; ++i) {
    const auto& [offsets, sizes] = *lists;
    const auto offset = tiff.number(offsets.at + i * offsets.width, offsets.width);
    const auto size = i < sizes.count ? tiff.number(sizes.at + i * sizes.width, sizes.width)
                                      : std::optional<std::uint64_t>(0);
    whole = offset && size && *offset <= tiff.size() && *size <= tiff.size() - *offset;
  }
  if (!whole)
    fail_picture(name, fmt::format("the TIFF file is cut short at {} bytes, or its directory is "
                                   "damaged; copy it again",
                                   bytes.size()));
}

std::optional<ExifOrientation> exif_orientation(ByteView exif) {
  using namespace std::string_view_literals;
  const std::size_t skip = starts_with(exif, "Exif\0\0"sv) ? 6 : 0;
  const ByteView bytes = exif.subspan(skip);
  if (!starts_with(bytes, "II"sv) && !starts_with(bytes, "MM"sv)) return {};
  const TiffBytes tiff(bytes);
  const auto directory = tiff.number(4, 4);
  const auto count = directory ? tiff.number(*directory, 2) : directory;
  for (std::uint64_t i = 0; count && i < *count; ++i) {
    const std::uint64_t at = *directory + 2 + 12 * i;
    const auto tag = tiff.number(at, 2), value = tiff.number(at + 8, 2);
    if (!tag || !value) return {};
    if (*tag == 274 && *value >= 1 && *value <= 8)
      return ExifOrientation{skip + std::size_t(at) + 8, starts_with(bytes, "MM"sv), int(*value)};
  }
  return {};
}

void set_exif_orientation(std::span<std::byte> exif, const ExifOrientation& place, int value) {
  exif[place.at] = std::byte(place.big_endian ? 0 : value);
  exif[place.at + 1] = std::byte(place.big_endian ? value : 0);
}

std::string icc_profile_name(ByteView profile) {
  const auto word = [&](std::size_t at) { return big_endian(profile, at, 4); };
  const auto letters = [&](std::size_t at, std::size_t count, std::size_t width) {
    std::string text;
    for (std::size_t i = 0; i + width <= count && at + i + width <= profile.size(); i += width) {
      const auto low = char(profile[at + i + width - 1]);
      if (low == 0 && width == 1) break;
      text += (width == 2 && profile[at + i] != std::byte(0)) || (low & 0x80) != 0 ? '?' : low;
    }
    return text;
  };
  constexpr std::size_t desc = 0x64657363, mluc = 0x6d6c7563, most_tags = 200;
  for (std::size_t i = 0; i < std::min(word(128), most_tags); ++i) {
    if (word(132 + 12 * i) != desc) continue;
    const std::size_t at = word(136 + 12 * i);
    if (at > profile.size()) return "";
    if (word(at) == desc) return letters(at + 12, std::min(word(at + 8), profile.size()), 1);
    if (word(at) == mluc) return letters(at + word(at + 24), std::min(word(at + 20), profile.size()), 2);
  }
  return "";
}

namespace {

/// Numbers and texts of an EXR head, one after the other; least significant bytes first.
class ExrHead {
 public:
  explicit ExrHead(ByteView bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size() - at_; }
  bool is_short() const { return short_; }

  std::int64_t number() {
    std::int32_t value = 0;
    if (const ByteView from = take(sizeof value); !from.empty()) std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  std::string_view text() {
    const std::string_view rest = text_of(bytes_.subspan(at_));
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    take(end + 1);
    return rest.substr(0, end);
  }
  ByteView take(std::size_t count) {
    short_ = short_ || count > left();
    if (short_) return {};
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
  bool short_ = false;
};

/// Whether what an attribute says of sizes fits into it: the decoder makes room for that before it reads.
bool is_sound_attribute(std::string_view type, ByteView value) {
  ExrHead inside(value);
  if (type == "preview") {
    const std::int64_t width = inside.number(), height = inside.number();
    constexpr std::int64_t most = 1 << 14;
    return width >= 0 && height >= 0 && width <= most && height <= most &&
           std::size_t(4 * width * height) <= inside.left();
  }
  if (type == "stringvector")
    while (inside.left() > 0 && !inside.is_short())
      if (const std::int64_t length = inside.number(); length < 0 || inside.take(std::size_t(length)).size() != std::size_t(length))
        return false;
  return !inside.is_short();
}

void check_exr_window(ByteView value, const std::string& name) {
  ExrHead box(value);
  const std::int64_t left = box.number(), top = box.number(), right = box.number(), bottom = box.number();
  const std::int64_t width = right - left + 1, height = bottom - top + 1;
  if (std::max(width, height) > max_picture_side) fail_too_large(name, width, height);
}

}  // namespace

void check_exr_head(ByteView bytes, const std::string& name) {
  constexpr unsigned several_parts = 0x10;  // of the second byte of flags
  const bool has_parts = bytes.size() > 5 && (std::to_integer<unsigned>(bytes[5]) & several_parts) != 0;
  ExrHead head(bytes);
  head.take(8);
  for (bool ended = false; !head.is_short();) {  // of a part's head, by an empty name; of all, where the next is empty
    const std::string attribute(head.text());
    if (attribute.empty() && (ended || !has_parts)) return;
    ended = attribute.empty();
    if (ended) continue;
    const std::string type(head.text());
    const std::int64_t size = head.number();
    if (head.is_short() || size < 0 || std::size_t(size) > head.left()) break;
    const ByteView value = head.take(std::size_t(size));
    if (!is_sound_attribute(type, value))
      fail_picture(name, fmt::format("damaged: '{}' of its head does not fit into the {} bytes it has; copy it again",
                                     attribute, size));
    if (attribute == "dataWindow" && type == "box2i") check_exr_window(value, name);
  }
  fail_picture(name, fmt::format("the head of the EXR file is cut short at {} bytes, or damaged; copy it again",
                                 bytes.size()));
}

}  // namespace mq
