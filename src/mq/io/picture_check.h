#pragma once
/// What can be told of a picture file from its bytes before it is decoded. Used inside this room.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "mq/io/file_names.h"

namespace mq {

inline constexpr const char* known_picture_formats = "PNG, JPEG, WebP, TIFF, EXR, BMP and TGA";

/// Throws `IoError`: "NAME: WHAT".
[[noreturn]] void fail_picture(const std::string& name, const std::string& what);
[[noreturn]] void fail_too_large(const std::string& name, std::int64_t width, std::int64_t height);

/// What the bytes are: "png", "jpeg", "webp", "tiff", "openexr", "bmp" or "targa". TGA has no mark of its
/// own and goes by the extension. Throws `IoError` for anything else, with a way out for KTX2.
std::string picture_format(std::span<const std::byte> bytes, const std::string& name);

/// Follows the chunks of a PNG to its end. Returns whether it says anything about colour. Throws
/// `IoError` when the file is cut short.
bool png_states_colour(std::span<const std::byte> bytes, const std::string& name);

/// Follows the segments of a JPEG to its end, which the decoder would paint grey if it were
/// missing. Throws `IoError` when the file is cut short.
void check_jpeg_end(std::span<const std::byte> bytes, const std::string& name);

/// Checks that the strips or tiles of the first picture in a TIFF lie in the file; the decoder
/// would paint those black that do not. Throws `IoError` when the file is cut short.
void check_tiff_extent(std::span<const std::byte> bytes, const std::string& name);

/// Checks the sizes an EXR head states, of windows and of its attributes, before the decoder makes room for
/// them. Throws `IoError`.
void check_exr_head(std::span<const std::byte> bytes, const std::string& name);

/// Where EXIF says how a picture is turned (CIPA DC-008, tag 274), and what it says: 1 upright to 8.
struct ExifOrientation {
  std::size_t at = 0;
  bool big_endian = false;
  int value = 1;
};

/// In EXIF bytes, with or without JPEG's "Exif" before them; nothing where they do not say it.
std::optional<ExifOrientation> exif_orientation(std::span<const std::byte> exif);
void set_exif_orientation(std::span<std::byte> exif, const ExifOrientation& place, int value);

/// What an ICC profile calls itself (its tag "desc", ICC.1), letters beyond ASCII as '?'; empty where it
/// does not say.
std::string icc_profile_name(std::span<const std::byte> profile);

}  // namespace mq
