#pragma once
/// Colours that lie in a picture file multiplied by alpha (associated alpha).

#include <OpenImageIO/imageio.h>

#include <span>
#include <string>
#include <vector>

namespace mq {

/// Whether colours lie in the file multiplied by alpha: always in OpenEXR, in TIFF and TGA where
/// they do not say otherwise. PNG and BMP know no such thing.
bool is_associated(const OIIO::ImageSpec& spec, const std::string& file_format);

/// Alpha is the last channel. A pixel with next to none shows nothing and is left as it is.
void divide_by_alpha(std::span<float> values, int channels);
std::vector<float> multiplied_by_alpha(std::span<const float> values, int channels);

}  // namespace mq
