#include "mq/io/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/fingerprint.h"
#include "mq/io/detail/held.h"
#include "mq/io/detail/picture_codec.h"
#include "mq/io/detail/picture_formats.h"
#include "mq/io/detail/plain_png.h"
#include "mq/io/path_status.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  const std::string name = path.string();
  if (!is_there(path))
    fail_picture(name, name.find('%') == name.npos
                           ? "no such file; check the name"
                           : fmt::format("no such file; names of frames are filled in where {} is "
                                         "given",
                                         option_name("frames")));
  if (is_folder(path))
    fail_picture(name, "a directory; a picture was expected");
  if (!std::filesystem::is_regular_file(path))
    fail_picture(name, "not an ordinary file; a picture was expected");
  std::ifstream in(path, std::ios::binary);
  if (!in)
    fail_picture(name,
                 fmt::format("cannot be read: {}; check its permissions", std::strerror(errno)));
  std::vector<std::byte> bytes(std::filesystem::file_size(path));
  in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
  if (std::size_t(in.gcount()) != bytes.size())
    fail_picture(name, fmt::format("only {} of {} bytes could be read", in.gcount(), bytes.size()));
  return bytes;
}

}  // namespace

bool holds_light(const PixelFormat& format) {
  return format.depth == Depth::half || format.depth == Depth::f32 ||
         (format.tags != nullptr && picture_codec().is_light(format));
}

PixelFormat named_channels(const std::vector<std::string>& names, Depth depth) {
  return picture_codec().named_channels(names, depth);
}

PictureInfo picture_info(const std::filesystem::path& path) {
  if (auto held = held_picture_info(path)) return *held;
  const std::vector<std::byte> bytes = read_bytes(path);
  if (auto plain = plain_png_info(bytes)) return *plain;
  return picture_codec().info(bytes, path.string());
}

namespace {

/// `by_itself`: nobody asked for the layer.
std::string layers_note(const PictureLayers& layers, const std::string& name, bool by_itself) {
  constexpr std::size_t most_named = 20;
  std::string others;
  for (std::size_t i = 0, named = 0; i < layers.names.size(); ++i) {
    if (i == layers.chosen) continue;
    if (named++ == most_named) {
      others += fmt::format(" and {} more", layers.names.size() - 1 - most_named);
      break;
    }
    others += (others.empty() ? "" : ", ") + shown(layers.names[i]);
  }
  return fmt::format("{}: its layer {} is processed; it has also {}, which {} kept{}", name,
                     shown(layers.names[layers.chosen]), others, layers.names.size() == 2 ? "is" : "are",
                     by_itself ? fmt::format(": {} chooses", option_name("layer")) : "");
}

}  // namespace

Texture read_texture_bytes(ByteView bytes, const std::string& name, const Progress& progress,
                           NotFinite not_finite, const std::string& layer) {
  std::optional<Texture> plain = layer.empty() ? read_plain_png(bytes, progress) : std::nullopt;
  Texture texture =
      plain ? std::move(*plain) : picture_codec().read(bytes, name, progress, not_finite, layer);
  texture.name = name;
  const std::string profile = plain ? "" : picture_codec().foreign_profile(texture.format);
  if (!profile.empty())
    texture.notes.push_back(fmt::format("{}: its ICC profile is {}, not sRGB: it is kept, and {} linear would take "
                                        "the values for sRGB",
                                        name, profile, option_name("space")));
  if (texture.format.layers) texture.notes.push_back(layers_note(*texture.format.layers, name, layer.empty()));
  texture.as_read = {fingerprint(texture), fingerprint(bytes)};
  return texture;
}

namespace {

EncodedPicture encoded(const Texture& texture, const std::string& name, const FileFormat& format,
                       const Progress& progress) {
  return fits_plain_png(texture, format)
             ? plain_png_bytes(texture, name, format, progress)
             : picture_codec().encode(texture, name, std::string(format.name), progress);
}

}  // namespace

EncodedPicture texture_bytes(const Texture& texture, const std::string& file_format,
                             const Progress& progress) {
  return encoded(texture, texture.name, format_named(file_format), progress);
}

Texture read_texture(const std::filesystem::path& path, const Progress& progress,
                     NotFinite not_finite, const std::string& layer) {
  if (auto held = held_texture(path, not_finite, layer, progress)) return std::move(*held);
  const std::vector<std::byte> bytes = read_bytes(path);
  Texture texture = read_texture_bytes(bytes, path.string(), progress, not_finite, layer);
  texture.name = path.filename().string();
  texture.path = path;
  return texture;
}

int orientation(const PixelFormat& format) {
  return format.tags == nullptr ? 1 : picture_codec().orientation(format);
}

namespace {

/// Orientations from 5 exchange columns and rows; 2, 3, 7 and 8 count columns of the file from the right,
/// 3, 4, 6 and 7 rows from below.
Image<float> turned(const Image<float>& stored, int orientation) {
  const int w = stored.width(), h = stored.height();
  const bool exchanged = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Image<float> upright(exchanged ? h : w, exchanged ? w : h, stored.channels());
  for (int y = 0; y < upright.height(); ++y)
    for (int x = 0; x < upright.width(); ++x) {
      const int column = exchanged ? y : x, row = exchanged ? x : y;
      std::ranges::copy(stored.pixel(from_right ? w - 1 - column : column, from_below ? h - 1 - row : row),
                        upright.pixel(x, y).begin());
    }
  return upright;
}

}  // namespace

Texture read_upright(const std::filesystem::path& path, const Progress& progress, NotFinite not_finite,
                     const std::string& layer) {
  Texture texture = read_texture(path, progress, not_finite, layer);
  const int tag = orientation(texture.format);
  if (tag == 1) return texture;
  if (texture.format.layers) {
    texture.notes.push_back(fmt::format("{}: its orientation {} is not heeded, as the other layers would not be "
                                        "turned",
                                        path.string(), tag));
    return texture;
  }
  texture.pixels = turned(texture.pixels, tag);
  texture.format = picture_codec().upright(texture.format);
  texture.as_read.pixels = fingerprint(texture);
  texture.notes.push_back(fmt::format("{}: turned upright, as its orientation {} asks for; what is written says "
                                      "that it is",
                                      path.string(), tag));
  return texture;
}

namespace {

/// The format that an extension names. Throws `InvalidInput` where it names none.
const FileFormat* writable_format(const std::filesystem::path& path) {
  const FileFormat* format = format_of_extension(path);
  if (format == nullptr)
    throw InvalidInput(
        fmt::format("{}: the extension names no picture format that can be written; "
                    "use .png, .jpg, .webp, .tif, .exr, .bmp or .tga",
                    path.string()));
  return format;
}

/// The file a picture was read from, if it still holds these pixels in this format and depth.
std::vector<std::byte> unchanged_source(const Texture& texture, const FileFormat& format) {
  std::error_code ignored;
  if (texture.path.empty() || texture.format.file_format != format.name ||
      !std::filesystem::is_regular_file(texture.path, ignored) || !keeps_pixels(texture))
    return {};
  try {
    std::vector<std::byte> bytes = read_bytes(texture.path);
    return fingerprint(bytes) == texture.as_read.bytes ? std::move(bytes)
                                                       : std::vector<std::byte>();
  } catch (const IoError&) {  // it is gone
    return {};
  }
}

}  // namespace

std::vector<std::string> write_texture(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress) {
  if (hold_texture(path, texture)) return {};
  const FileFormat* format = writable_format(path);
  if (const auto bytes = unchanged_source(texture, *format); !bytes.empty()) {
    write_file(path, bytes);
    return {};
  }
  return write_encoded(path, texture, progress);
}

std::vector<std::string> write_encoded(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress) {
  const FileFormat* format = writable_format(path);
  const EncodedPicture picture = encoded(texture, path.string(), *format, progress);
  write_file(path, picture.bytes);
  return picture.notes;
}

std::vector<std::string> write_image(const std::filesystem::path& path, const Image<float>& pixels,
                                     Depth depth) {
  Texture texture;
  texture.pixels = pixels;
  texture.format.depth = depth;
  return write_texture(path, texture);
}

}  // namespace mq
