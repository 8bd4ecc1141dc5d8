#pragma once
/// Picture files: PNG, JPEG, WebP, TIFF, OpenEXR, BMP and TGA (`read_texture` and `write_texture` of
/// model.h, and the same in memory for pictures embedded in a model).
///
/// Values are those stored: no colour conversion, and no turning by an orientation tag but by
/// `read_upright`. Integers are
/// divided by their largest value; floating point is taken as it is and must be finite. Alpha is
/// never multiplied in: where a file holds colours multiplied by it (associated alpha: OpenEXR,
/// TIFF and TGA that say so) they are divided by it and multiplied again on writing, which gives
/// back integers and 16-bit floating point exactly and 32-bit floating point to its last bit; where
/// alpha is 0 colours are kept as they lie in the file. What is kept for writing: depth, channel
/// names and order, ICC profile, gamma, resolution and the other tags the format knows. What is
/// not:
///
/// - PNG and TIFF palettes become RGB or RGBA with 8 bits, fewer than 8 bits become 8;
/// - doubles become floats; of several pages of a TIFF the first is read (a note says so);
/// - JPEG is encoded again (quality 98, chroma not subsampled), so that texels nobody touched
/// change
///   by its rounding (a note says so);
/// - WebP is always written without loss, also one that was read with (a note says so), and grey as RGB;
/// - the way a file is compressed, interlaced and tiled.
///
/// OpenEXR's parts and layers: a layer is what of a part's channels has one name before the last dot. R, G,
/// B and A there are one layer and every further channel is one by itself (Z); without R, G and B all are
/// one. It is called by that name after its part's, without either by its channels (RGBA). Of several the
/// one asked for is read, or the first with R, G and B (a note names it and the others). Written as
/// OpenEXR with the same size and channels, all others come back value for value and type for type, with
/// their tags; otherwise a note says that they are left behind. MIP levels are not kept, and compression
/// with loss becomes zip.
///
/// Refused: CMYK, signed and 32-bit integers, deep images, more than 32768 pixels a side, files cut
/// short. Only detail/picture_* know OpenImageIO, which is loaded with the first picture
/// (detail/picture_codec.h).

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// Pixels a side that a picture may have at most; the limit of an atlas.
inline constexpr int max_picture_side = 32768;

/// What the head of a picture file says.
struct PictureInfo {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< their names: R, G, B, A, Y, ...
  PixelFormat format;
};

/// Reads the head only. Throws `IoError` as `read_texture` does.
PictureInfo picture_info(const std::filesystem::path& path);

/// The format of an EXR made here whose channels have these names, none of which is alpha. They
/// must be in alphabetical order, in which EXR keeps them.
PixelFormat named_channels(const std::vector<std::string>& names, Depth depth);

/// Reads a picture from memory; the format is found by content. `name` is used in messages and
/// becomes the texture's name.
Texture read_texture_bytes(std::span<const std::byte> bytes, const std::string& name,
                           const Progress& progress = {}, NotFinite not_finite = NotFinite::refuse,
                           const std::string& layer = {});

/// How a picture says that it is to be turned to be seen (EXIF, TIFF): 1, as it is, to 8.
int orientation(const PixelFormat& format);

/// `read_texture` for a picture that is looked at, not for a texture of a model, whose texture coordinates
/// mean the pixels as they are stored (renderers do not heed the tag): turned as it says, and the format
/// says upright, so that nothing turns it again. A note where it was turned. Unchanged it is still the
/// file that was read, byte for byte. One layer of several is not turned, as the others would not be; a
/// note says so.
Texture read_upright(const std::filesystem::path& path, const Progress& progress = {},
                     NotFinite not_finite = NotFinite::refuse, const std::string& layer = {});

/// A picture encoded in memory, with what `write_texture` would return.
struct EncodedPicture {
  std::vector<std::byte> bytes;
  std::vector<std::string> notes;
};

/// `write_texture` without looking whether the file that the picture was read from could be copied.
std::vector<std::string> write_encoded(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress = {});

/// Encodes in `file_format`: "png", "jpeg", "webp", "tiff", "openexr", "bmp" or "targa".
EncodedPicture texture_bytes(const Texture& texture, const std::string& file_format,
                             const Progress& progress = {});

}  // namespace mq
