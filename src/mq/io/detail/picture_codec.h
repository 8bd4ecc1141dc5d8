#pragma once
/// Where pictures are decoded and encoded: a module of the project's own, libmarquetry_pictures.so,
/// which alone is linked with OpenImageIO. It is loaded when the first picture is read or written:
/// OpenImageIO brings more than 250 shared libraries along, and whoever needs none of them shall not
/// wait for them.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mq/io/image_file.h"

namespace mq {

/// What the module offers.
class PictureCodec {
 public:
  virtual ~PictureCodec() = default;

  /// What the head says. Throws `IoError` where it is not that of a picture that can be used, and
  /// `Unsupported` where OpenImageIO was built without its format; so do the others.
  virtual PictureInfo info(std::span<const std::byte> bytes, const std::string& name) const = 0;

  /// Pixels, format and notes; the rest of a `Texture` is left to the caller. `layer`: its name; empty:
  /// the colours. Throws `InvalidInput` where it is not there.
  virtual Texture read(std::span<const std::byte> bytes, const std::string& name,
                       const Progress& progress, NotFinite not_finite, const std::string& layer) const = 0;

  /// Throws `InvalidInput` where the format cannot hold the picture, `IoError` where it is not
  /// finite or encoding fails. `name` is used in messages, `file_format` as in `texture_bytes`.
  virtual EncodedPicture encode(const Texture& texture, const std::string& name,
                                const std::string& file_format, const Progress& progress) const = 0;

  virtual PixelFormat named_channels(const std::vector<std::string>& names, Depth depth) const = 0;

  /// Whether what was read from a file is light, by its tags.
  virtual bool is_light(const PixelFormat& format) const = 0;

  /// The name of a profile that is another than sRGB, in quotation marks; empty: none.
  virtual std::string foreign_profile(const PixelFormat& format) const = 0;

  /// How the file says that its pixels are to be turned, 1 (as they are) to 8, and the format of those
  /// that were.
  virtual int orientation(const PixelFormat& format) const = 0;
  virtual PixelFormat upright(const PixelFormat& format) const = 0;
};

/// The module's only symbol: its codec, or null where `version` is not the one that it was built
/// with.
using PictureCodecOfModule = const PictureCodec* (*)(const char* version);
inline constexpr const char* picture_codec_symbol = "marquetry_picture_codec";
inline constexpr const char* picture_module = "libmarquetry_pictures.so";

/// The codec of the module, loaded by the first call. Throws `Unsupported` where it cannot be,
/// saying why and where it was expected.
const PictureCodec& picture_codec();

}  // namespace mq
