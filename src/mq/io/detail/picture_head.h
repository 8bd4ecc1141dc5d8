#pragma once
/// The head of a picture file: its size and depth, channels and tags.

#include <OpenImageIO/imageio.h>

#include "mq/io/bytes.h"
#include "mq/io/detail/picture_formats.h"
#include "mq/io/model.h"

namespace mq {

/// What OpenImageIO calls a depth, and back.
OIIO::TypeDesc type_of(Depth depth);
Depth depth_of(const OIIO::TypeDesc& type);

/// Whether what was read from a file is light, by its tags.
bool is_light(const PixelFormat& format);

/// How the file says its pixels are to be turned (EXIF): 1, as they are, to 8.
int stored_orientation(const PixelFormat& format);
/// The same format saying that they are upright, without the sizes of EXIF, which may be the other way
/// round.
PixelFormat upright_format(const PixelFormat& format);

/// The name of an ICC profile that is another than sRGB, in quotation marks; empty for sRGB, for none, and
/// where values are light.
std::string foreign_profile_name(const PixelFormat& format);

/// What a PNG says of its colours (`png_colour_chunks`) is an attribute of its head. It goes into a PNG with as many
/// channels: what is to be in the new file, empty where it says nothing of its own.
void keep_png_colour(ByteView png, OIIO::ImageSpec& spec);
ByteView png_colour_for(const Texture& texture);

/// The head of the new file: the one that was read where it fits the pixels, otherwise a plain one.
OIIO::ImageSpec spec_for(const Texture& texture, const FileFormat& format, Depth depth);

}  // namespace mq
