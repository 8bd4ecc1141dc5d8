#include "mq/io/detail/picture_head.h"

#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "mq/io/bytes.h"
#include "mq/io/detail/picture_alpha.h"
#include "mq/io/detail/picture_metadata.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;

/// The attribute that holds the chunks; others than PNG leave it out by its first letters.
constexpr const char* png_colour = "png:colour";

/// Tags that describe how a file was laid out, not what it shows.
bool describes_layout(const std::string& tag) {
  static const std::array<std::string_view, 11> names = {"oiio:BitsPerSample",
                                                         "oiio:subimages",
                                                         "oiio:subimagename",
                                                         "tiff:RowsPerStrip",
                                                         "tiff:PhotometricInterpretation",
                                                         "tiff:ColorSpace",
                                                         "tiff:PlanarConfiguration",
                                                         "planarconfig",
                                                         "jpeg:subsampling",
                                                         "openexr:chunkCount",
                                                         "openexr:lineOrder"};
  return std::ranges::find(names, tag) != names.end();
}

bool belongs_to_format(const std::string& tag) {
  static const std::array<std::string_view, 10> prefixes = {
      "png:",   "jpeg:", "tiff:",       "openexr:",     "bmp:",
      "targa:", "webp:", "compression", "screenWindow", "PixelAspectRatio"};
  return std::ranges::any_of(prefixes, [&](std::string_view p) { return tag.starts_with(p); });
}

/// What OpenImageIO also writes as IPTC.
bool goes_as_iptc(const std::string& tag) {
  static const std::array<std::string_view, 4> names = {"Artist", "Copyright", "ImageDescription", "Software"};
  return tag.starts_with("IPTC:") || std::ranges::find(names, tag) != names.end();
}

/// Plain names, which OpenEXR sorts: they must sort in the order of the channels.
void name_channels(ImageSpec& spec) {
  if (spec.nchannels > 4)
    for (int c = 0; c < spec.nchannels; ++c) spec.channelnames[c] = fmt::format("channel{:04}", c);
  spec.alpha_channel = spec.nchannels == 4 ? 3 : spec.nchannels == 2 ? 1 : -1;
}

/// Alpha as the format has it; where there is a choice as in the file that was read, or
/// unassociated.
void state_alpha(const ImageSpec* read, const FileFormat& format, ImageSpec& spec) {
  const bool as_read = read != nullptr && format.name == "tiff" && is_associated(*read, "tiff");
  if (format.name == "openexr" || as_read)
    spec.erase_attribute("oiio:UnassociatedAlpha");
  else if (spec.alpha_channel >= 0)
    spec["oiio:UnassociatedAlpha"] = 1;
}

void take_over(const ImageSpec& read, bool same_format, Depth depth, ImageSpec& spec) {
  for (const auto& tag : read.extra_attribs) {
    const std::string name = tag.name().string();
    if (goes_as_iptc(name) && tag.get_string().empty()) continue;  // cannot be encoded, and says nothing
    if (!describes_layout(name) && (same_format || !belongs_to_format(name)))
      spec.extra_attribs.add_or_replace(tag);
  }
  if (read.nchannels == spec.nchannels) {
    spec.channelnames = read.channelnames;
    spec.alpha_channel = read.alpha_channel;
    spec.z_channel = read.z_channel;
    if (same_format && depth_of(read.format) == depth) spec.channelformats = read.channelformats;
  }
  if (read.width == spec.width && read.height == spec.height) {
    spec.x = read.x, spec.y = read.y;
    spec.full_x = read.full_x, spec.full_y = read.full_y;
    spec.full_width = read.full_width, spec.full_height = read.full_height;
  }
}

}  // namespace

Depth depth_of(const TypeDesc& type) {
  if (type == TypeDesc::UINT8) return Depth::u8;
  if (type == TypeDesc::UINT16) return Depth::u16;
  return type == TypeDesc::HALF ? Depth::half : Depth::f32;
}

TypeDesc type_of(Depth depth) {
  switch (depth) {
    case Depth::u8: return TypeDesc::UINT8;
    case Depth::u16: return TypeDesc::UINT16;
    case Depth::half: return TypeDesc::HALF;
    case Depth::f32: break;
  }
  return TypeDesc::FLOAT;
}

bool is_light(const PixelFormat& format) {
  const auto* read = static_cast<const ImageSpec*>(format.tags.get());
  if (read == nullptr) return false;
  return depth_of(read->format) >= Depth::half ||
         OIIO::Strutil::iequals(read->get_string_attribute("oiio:ColorSpace"), "linear");
}

int stored_orientation(const PixelFormat& format) {
  const auto* read = static_cast<const ImageSpec*>(format.tags.get());
  const int value = read ? read->get_int_attribute("Orientation", 1) : 1;
  return value >= 1 && value <= 8 ? value : 1;
}

PixelFormat upright_format(const PixelFormat& format) {
  const auto* read = static_cast<const ImageSpec*>(format.tags.get());
  if (read == nullptr) return format;
  auto spec = std::make_shared<ImageSpec>(*read);
  spec->attribute("Orientation", 1);
  for (const char* size : {"Exif:PixelXDimension", "Exif:PixelYDimension"}) spec->erase_attribute(size);
  return {format.depth, format.file_format, std::move(spec), format.layers};
}

std::string foreign_profile_name(const PixelFormat& format) {
  const auto* read = static_cast<const ImageSpec*>(format.tags.get());
  const OIIO::ParamValue* found = read && !is_light(format) ? read->find_attribute("ICCProfile") : nullptr;
  if (found == nullptr) return "";
  const std::string name =
      icc_profile_name({static_cast<const std::byte*>(found->data()), std::size_t(found->datasize())});
  return OIIO::Strutil::icontains(name, "srgb") ? "" : name.empty() ? "without a name" : shown(name);
}

void keep_png_colour(ByteView png, ImageSpec& spec) {
  const Bytes chunks = png_colour_chunks(png);
  if (!chunks.empty())
    spec.attribute(png_colour, TypeDesc(TypeDesc::UINT8, int(chunks.size())), chunks.data());
}

ByteView png_colour_for(const Texture& texture) {
  const auto* read = static_cast<const ImageSpec*>(texture.format.tags.get());
  const OIIO::ParamValue* found = read ? read->find_attribute(png_colour) : nullptr;
  if (found == nullptr || read->nchannels != texture.pixels.channels()) return {};
  return {static_cast<const std::byte*>(found->data()), std::size_t(found->datasize())};
}

ImageSpec spec_for(const Texture& texture, const FileFormat& format, Depth depth) {
  const Image<float>& pixels = texture.pixels;
  ImageSpec spec(pixels.width(), pixels.height(), pixels.channels(), type_of(depth));
  const auto* read = static_cast<const ImageSpec*>(texture.format.tags.get());
  if (read == nullptr || read->nchannels != spec.nchannels) name_channels(spec);
  const bool same_format = texture.format.file_format == format.name;
  if (read != nullptr) take_over(*read, same_format, depth, spec);
  state_alpha(same_format ? read : nullptr, format, spec);
  if (is_light(texture.format) && format.name == "png") spec["oiio:ColorSpace"] = "Linear";
  // An empty date keeps the library from writing today's: equal pictures are equal files.
  if (spec.find_attribute("DateTime") == nullptr) spec["DateTime"] = "";
  spec.erase_attribute(png_colour);
  if (format.name == "png") spec.erase_attribute("ICCProfile:.*");  // read off the profile, and written as texts
  if (format.name == "jpeg") {
    spec["Compression"] = "jpeg:98";
    spec["jpeg:subsampling"] = "4:4:4";
  }
  return spec;
}

}  // namespace mq
