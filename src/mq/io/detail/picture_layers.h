#pragma once
/// Parts and layers of an OpenEXR file (image_file.h says what a layer is).

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/image_file.h"

namespace mq {

/// Channels first … first + count − 1 of a part.
struct FileLayer {
  std::string name;
  int part = 0;
  int first = 0;
  int count = 0;
  bool is_colour = false;  ///< R, G, B and perhaps A
};

/// Of all parts; `parts` are their heads. A file of one part has no part names.
std::vector<FileLayer> layers_of(const std::vector<OIIO::ImageSpec>& parts);

/// The heads of all parts.
std::vector<OIIO::ImageSpec> heads_of(OIIO::ImageInput& input);

/// The layer of this name; empty: the first with colours, or the first of all. Throws `InvalidInput` where
/// there is none of that name, or several; `file` is used in messages.
std::size_t layer_named(const std::vector<FileLayer>& layers, const std::string& name, const std::string& file);

/// The head of a picture that is this layer of the part alone.
OIIO::ImageSpec head_of_layer(const OIIO::ImageSpec& part, const FileLayer& layer);

/// Whether the picture has the size and the channels of the layer that it was read from, so that it can be
/// written among the others.
bool fits_its_layer(const Texture& texture);

/// The file that the picture is a layer of, with that layer's values replaced by the picture's with this
/// depth. Parts are decoded and encoded one by one, as they are stored. A note where their compression would
/// lose and was changed. Throws `IoError` where a part cannot be decoded. Returns how many values were
/// clamped to what 16-bit floating point can hold in `clamped`.
EncodedPicture encode_among_layers(const Texture& texture, const std::string& name, Depth depth,
                                   std::int64_t& clamped, const Progress& progress);

}  // namespace mq
