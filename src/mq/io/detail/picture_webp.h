#pragma once
/// WebP, by libwebp itself: OpenImageIO multiplies colours by alpha on the way and writes other colours
/// than it was given where alpha is 0.

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <span>
#include <string>

#include "mq/io/detail/picture_formats.h"
#include "mq/io/image_file.h"

namespace mq {

/// Size, channels and tags (ICC profile, EXIF, XMP). Throws `IoError` for a damaged or truncated file and
/// for an animation. `name` is used in messages; so below.
PictureInfo webp_info(std::span<const std::byte> bytes, const std::string& name);

/// 8 bits, RGB, or RGBA where the file has alpha. A note where it was compressed with loss.
Texture read_webp(std::span<const std::byte> bytes, const std::string& name, const Progress& progress);

/// Without loss, colours under alpha 0 too. Grey is spread to RGB, which a note says. Throws
/// `InvalidInput` for more than 16383 pixels a side.
EncodedPicture webp_bytes(const Texture& texture, const std::string& name, const FileFormat& format,
                          const Progress& progress);

}  // namespace mq
