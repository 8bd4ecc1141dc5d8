#pragma once
/// A picture file in memory that is being decoded.

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_layers.h"
#include "mq/io/model.h"

namespace mq {

struct OpenPicture {
  std::string name;
  std::string file_format;
  Bytes sound;  // the file without what was damaged of its metadata; empty: as it is
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;  // outlives `input`
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageSpec spec;           // of the layer alone
  std::vector<FileLayer> layers;  // of an OpenEXR file
  std::size_t layer = 0;
  std::vector<std::string> notes;
};

/// Reads the head; `bytes` must stay. Throws `IoError` where it is not that of a picture that can
/// be used, `Unsupported` where OpenImageIO was built without its format, and `InvalidInput` where the
/// layer is not there (empty: the colours). `name` is used in messages.
OpenPicture open_picture(std::span<const std::byte> bytes, const std::string& name,
                         const std::string& layer = {});

/// Colours are divided by alpha where they lie in the file multiplied by it.
Image<float> read_pixels(OpenPicture& p, const Progress& progress, NotFinite not_finite);

/// What the head says, with all of its tags.
PixelFormat format_read(const OpenPicture& p);

/// Rows decoded at a time: a multiple of every EXR block and of the tiles.
int strip_rows(const OIIO::ImageSpec& spec);

/// The first line of an error of OpenImageIO.
std::string explain(const std::string& error);

}  // namespace mq
