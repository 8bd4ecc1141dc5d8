#pragma once
/// Pictures encoded in memory.

#include <string>

#include "mq/base/progress.h"
#include "mq/io/detail/picture_formats.h"
#include "mq/io/image_file.h"

namespace mq {

/// Throws `InvalidInput` where the format cannot hold the picture, `IoError` where it is not finite
/// or encoding fails, and `Unsupported` where OpenImageIO was built without the format. `name` is
/// used in messages.
EncodedPicture encode_picture(const Texture& texture, const std::string& name,
                              const FileFormat& format, const Progress& progress);

}  // namespace mq
