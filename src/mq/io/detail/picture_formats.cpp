#include "mq/io/detail/picture_formats.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

const std::array<FileFormat, 7>& file_formats() {
  using enum Depth;
  constexpr int any = 1024;
  static const std::array<FileFormat, 7> formats = {{
      {"png", {".png"}, 4, {u8, u16, u16, u16}},
      {"jpeg", {".jpg", ".jpeg"}, 3, {u8, u8, u8, u8}},
      {"tiff", {".tif", ".tiff"}, any, {u8, u16, f32, f32}},
      {"openexr", {".exr"}, any, {half, f32, half, f32}},
      {"bmp", {".bmp"}, 4, {u8, u8, u8, u8}},
      {"targa", {".tga"}, 4, {u8, u8, u8, u8}},
      {"webp", {".webp"}, 4, {u8, u8, u8, u8}},
  }};
  return formats;
}

}  // namespace

const FileFormat& format_named(const std::string& name) {
  for (const FileFormat& f : file_formats())
    if (f.name == name) return f;
  throw InvalidInput(
      fmt::format("unknown picture format \"{}\": {} can be written", name, known_picture_formats));
}

const FileFormat* format_of_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const FileFormat& f : file_formats())
    if (std::ranges::find(f.extensions, extension) != f.extensions.end()) return &f;
  return nullptr;
}

}  // namespace mq
