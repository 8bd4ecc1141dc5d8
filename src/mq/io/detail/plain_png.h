#pragma once
/// PNG files that hold pixels and nothing else, which need no library of pictures.
///
/// Plain: 8 or 16 bits, grey or RGB, with alpha or without, not interlaced, and no chunks beside
/// IHDR, IDAT, IEND and an offset (oFFs) of 0. All others, and damaged ones, are left to the codec of
/// picture_codec.h, which says what is wrong with them; it reads plain ones to the same values.
/// Format: ISO/IEC 15948.

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "mq/io/detail/picture_formats.h"
#include "mq/io/image_file.h"

namespace mq {

/// Nothing where the file is not a plain one with all its chunks.
std::optional<PictureInfo> plain_png_info(std::span<const std::byte> bytes);

/// Pixels and format. Nothing where the file is not a plain one, or is damaged.
std::optional<Texture> read_plain_png(std::span<const std::byte> bytes, const Progress& progress);

/// Whether a texture has nothing to say but its pixels, so that `plain_png_bytes` writes all of it.
bool fits_plain_png(const Texture& texture, const FileFormat& format);

/// Throws as `PictureCodec::encode`.
EncodedPicture plain_png_bytes(const Texture& texture, const std::string& name,
                               const FileFormat& format, const Progress& progress);

}  // namespace mq
