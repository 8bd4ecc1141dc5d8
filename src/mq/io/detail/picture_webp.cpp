// A WebP file is a RIFF of chunks (RFC 9649). libwebp decodes and encodes its pixels, libwebpmux its
// other chunks: the profile, which goes in and out as an attribute of OpenImageIO, and EXIF and XMP, which are
// kept as they are but for the orientation.
#include "mq/io/detail/picture_webp.h"

#include <fmt/format.h>
#include <webp/decode.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_head.h"
#include "mq/io/detail/picture_values.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

constexpr const char *webp_exif = "webp:exif", *webp_xmp = "webp:xmp";

using Mux = std::unique_ptr<WebPMux, decltype([](WebPMux* mux) { WebPMuxDelete(mux); })>;

const std::uint8_t* data_of(ByteView bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

WebPBitstreamFeatures webp_features(ByteView bytes, const std::string& name) {
  std::uint32_t size = 0;
  if (bytes.size() >= 12) std::memcpy(&size, bytes.data() + 4, 4);
  if (bytes.size() < 12 || size > bytes.size() - 8)
    fail_picture(name, fmt::format("the WebP file is cut short at {} bytes; copy it again", bytes.size()));
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(bytes), bytes.size(), &features) != VP8_STATUS_OK)
    fail_picture(name, "cannot be read as webp: its head is damaged; copy it again or convert it");
  if (features.has_animation)
    fail_picture(name, "an animated WebP; save one of its pictures as PNG or WebP first");
  return features;
}

/// The bytes of an attribute; none where it is not there.
ByteView bytes_of(const OIIO::ImageSpec& spec, const char* attribute) {
  const OIIO::ParamValue* found = spec.find_attribute(attribute);
  return found ? ByteView(static_cast<const std::byte*>(found->data()), std::size_t(found->datasize()))
               : ByteView();
}

void read_chunks(ByteView bytes, OIIO::ImageSpec& spec) {
  const WebPData all{data_of(bytes), bytes.size()};
  const Mux mux(WebPMuxCreate(&all, 0));
  if (!mux) return;
  for (const auto& [kind, name] :
       {std::pair("ICCP", "ICCProfile"), std::pair("EXIF", webp_exif), std::pair("XMP ", webp_xmp)}) {
    WebPData chunk;
    if (WebPMuxGetChunk(mux.get(), kind, &chunk) == WEBP_MUX_OK && chunk.size > 0)
      spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::UINT8, int(chunk.size)), chunk.bytes);
  }
  if (const std::optional<ExifOrientation> found = exif_orientation(bytes_of(spec, webp_exif)))
    spec["Orientation"] = found->value;
}

PictureInfo info_of(const WebPBitstreamFeatures& features, ByteView bytes) {
  OIIO::ImageSpec spec(features.width, features.height, features.has_alpha ? 4 : 3, OIIO::TypeDesc::UINT8);
  spec["oiio:UnassociatedAlpha"] = 1;
  read_chunks(bytes, spec);
  return {features.width, features.height, spec.channelnames,
          {Depth::u8, "webp", std::make_shared<const OIIO::ImageSpec>(spec)}};
}

/// The pixels' file with what the head says beside them.
std::vector<std::byte> with_chunks(const WebPMemoryWriter& pixels, const OIIO::ImageSpec& spec,
                                   const std::string& name) {
  const auto copied = [](const std::uint8_t* from, std::size_t size) {
    const auto* bytes = reinterpret_cast<const std::byte*>(from);
    return std::vector<std::byte>(bytes, bytes + size);
  };
  const ByteView profile = bytes_of(spec, "ICCProfile"), xmp = bytes_of(spec, webp_xmp);
  const ByteView as_read = bytes_of(spec, webp_exif);
  Bytes exif(as_read.begin(), as_read.end());
  if (const std::optional<ExifOrientation> found = exif_orientation(exif))
    set_exif_orientation(exif, *found, spec.get_int_attribute("Orientation", 1));
  if (profile.empty() && exif.empty() && xmp.empty()) return copied(pixels.mem, pixels.size);
  const Mux mux(WebPMuxNew());
  const WebPData image{pixels.mem, pixels.size};
  bool done = mux && WebPMuxSetImage(mux.get(), &image, 1) == WEBP_MUX_OK;
  for (const auto& [kind, bytes] :
       {std::pair("ICCP", profile), std::pair("EXIF", ByteView(exif)), std::pair("XMP ", xmp)}) {
    const WebPData chunk{data_of(bytes), bytes.size()};
    done = done && (bytes.empty() || WebPMuxSetChunk(mux.get(), kind, &chunk, 1) == WEBP_MUX_OK);
  }
  WebPData all{nullptr, 0};
  if (!done || WebPMuxAssemble(mux.get(), &all) != WEBP_MUX_OK)
    fail_picture(name, "its profile and other tags cannot be written as WebP");
  std::vector<std::byte> written = copied(all.bytes, all.size);
  WebPDataClear(&all);
  return written;
}

/// The values as libwebp takes them: 8 bits, RGB or RGBA.
std::vector<std::byte> webp_pixels(const Image<float>& pixels, std::int64_t& clamped) {
  std::vector<std::byte> stored;
  clamped = quantise<std::uint8_t>(pixels.values(), stored);
  const int channels = pixels.channels();
  if (channels >= 3) return stored;
  std::vector<std::byte> spread;
  for (std::size_t i = 0; i < stored.size(); i += std::size_t(channels)) {
    spread.insert(spread.end(), 3, stored[i]);
    if (channels == 2) spread.push_back(stored[i + 1]);
  }
  return spread;
}

}  // namespace

PictureInfo webp_info(ByteView bytes, const std::string& name) {
  return info_of(webp_features(bytes, name), bytes);
}

Texture read_webp(ByteView bytes, const std::string& name, const Progress& progress) {
  const WebPBitstreamFeatures features = webp_features(bytes, name);
  const PictureInfo info = info_of(features, bytes);
  Texture texture;
  texture.format = info.format;
  const int channels = int(info.channels.size());
  const std::size_t row = std::size_t(info.width) * std::size_t(channels);
  std::vector<std::uint8_t> stored(row * std::size_t(info.height));
  const auto decode = channels == 4 ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
  if (!decode(data_of(bytes), bytes.size(), stored.data(), stored.size(), int(row)))
    fail_picture(name, "the WebP file is cut short or damaged; copy it again");
  texture.pixels = Image<float>(info.width, info.height, channels);
  for (std::size_t i = 0; i < stored.size(); ++i)
    texture.pixels.values()[i] = float(stored[i]) / 255.0F;
  if (features.format == 1)
    texture.notes.push_back(name + ": compressed with loss, as WebP can; it is written without, larger, so that "
                                   "untouched texels stay what they are");
  progress.at(1);
  return texture;
}

EncodedPicture webp_bytes(const Texture& texture, const std::string& name, const FileFormat& format,
                          const Progress& progress) {
  check_writable(texture, name, format);
  const Image<float>& pixels = texture.pixels;
  if (pixels.width() > WEBP_MAX_DIMENSION || pixels.height() > WEBP_MAX_DIMENSION)
    throw InvalidInput(fmt::format("{}: {} x {} pixels, and WebP holds {} a side; choose .png", name,
                                   pixels.width(), pixels.height(), WEBP_MAX_DIMENSION));
  std::int64_t clamped = 0;
  const std::vector<std::byte> stored = webp_pixels(pixels, clamped);
  const bool alpha = pixels.channels() == 4 || pixels.channels() == 2;

  WebPConfig config;
  WebPPicture picture;
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  if (!WebPConfigInit(&config) || !WebPPictureInit(&picture) || !WebPConfigLosslessPreset(&config, 4))
    throw Unsupported(name + ": this libwebp is another than the headers it was built with; choose .png");
  config.exact = 1;
  picture.use_argb = 1;
  picture.width = pixels.width();
  picture.height = pixels.height();
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const auto* from = data_of(stored);
  const bool written = (alpha ? WebPPictureImportRGBA(&picture, from, 4 * pixels.width())
                              : WebPPictureImportRGB(&picture, from, 3 * pixels.width())) &&
                       WebPEncode(&config, &picture);
  const int error = picture.error_code;
  WebPPictureFree(&picture);
  EncodedPicture encoded;
  if (written) encoded.bytes = with_chunks(writer, spec_for(texture, format, Depth::u8), name);
  WebPMemoryWriterClear(&writer);
  if (!written) fail_picture(name, fmt::format("cannot be written as webp (error {} of libwebp)", error));
  encoded.notes = notes_on(name, texture, format, Depth::u8, clamped, is_light(texture.format));
  if (pixels.channels() < 3) encoded.notes.push_back(name + ": WebP has no grey; written as RGB");
  progress.at(1);
  return encoded;
}

}  // namespace mq
