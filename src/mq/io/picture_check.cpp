#include "mq/io/picture_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using Bytes = std::span<const std::byte>;

bool starts_with(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
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

std::string lower_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string picture_format(Bytes bytes, const std::string& name) {
  using namespace std::string_view_literals;
  if (bytes.empty()) fail_picture(name, "the file is empty; a picture was expected");
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n"sv)) return "png";
  if (starts_with(bytes, "\xff\xd8\xff"sv)) return "jpeg";
  if (starts_with(bytes, "II*\0"sv) || starts_with(bytes, "MM\0*"sv) ||
      starts_with(bytes, "II+\0"sv) || starts_with(bytes, "MM\0+"sv))
    return "tiff";
  if (starts_with(bytes, "v/1\x01"sv)) return "openexr";
  if (starts_with(bytes, "BM"sv)) return "bmp";
  if (lower_extension(name) == ".tga") return "targa";
  fail_picture(
      name, fmt::format("not a picture this program reads (its first bytes are of another kind); "
                        "{} are read",
                        known_picture_formats));
}

bool png_states_colour(Bytes bytes, const std::string& name) {
  bool colour = false;
  for (std::size_t at = 8;;) {
    if (bytes.size() < at + 12) break;
    const auto byte = [&](std::size_t i) { return std::size_t(bytes[at + i]); };
    const std::size_t length = byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (bytes.size() - at - 12 < length) break;
    if (type == "IEND") return colour;
    colour = colour || type == "sRGB" || type == "gAMA" || type == "iCCP";
    at += 12 + length;
  }
  fail_picture(name,
               fmt::format("the PNG file is cut short at {} bytes; copy it again", bytes.size()));
}

void check_jpeg_end(Bytes bytes, const std::string& name) {
  std::size_t at = 2;
  const auto byte = [&](std::size_t i) { return unsigned(bytes[i]); };
  while (at + 1 < bytes.size()) {
    const unsigned marker = byte(at) == 0xff ? byte(at + 1) : 0;
    const bool alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (marker == 0xd9) return;
    if (marker == 0x00 || marker == 0xff)
      ++at;  // coded pixels, or filling
    else if (alone)
      at += 2;
    else if (at + 3 < bytes.size())
      at += 2 + (byte(at + 2) << 8 | byte(at + 3));
    else
      break;
  }
  fail_picture(name,
               fmt::format("the JPEG file is cut short at {} bytes; copy it again", bytes.size()));
}

void check_exr_windows(Bytes bytes, const std::string& name) {
  using namespace std::string_view_literals;
  constexpr std::string_view mark = "dataWindow\0box2i\0\x10\0\0\0"sv;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (auto at = text.find(mark); at != text.npos; at = text.find(mark, at + 1)) {
    std::array<std::int32_t, 4> box;  // left, top, right, bottom, all inside
    if (at + mark.size() + sizeof box > text.size()) return;
    std::memcpy(box.data(), text.data() + at + mark.size(), sizeof box);
    const std::int64_t width = std::int64_t(box[2]) - box[0] + 1;
    const std::int64_t height = std::int64_t(box[3]) - box[1] + 1;
    if (std::max(width, height) > max_picture_side) fail_too_large(name, width, height);
  }
}

}  // namespace mq
