// What libmarquetry_pictures.so offers to the library (picture_codec.h).

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <new>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/detail/picture_codec.h"
#include "mq/io/detail/picture_head.h"
#include "mq/io/detail/picture_reader.h"
#include "mq/io/detail/picture_webp.h"
#include "mq/io/detail/picture_writer.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

class OpenImageIoCodec final : public PictureCodec {
 public:
  PictureInfo info(std::span<const std::byte> bytes, const std::string& name) const override {
    if (picture_format(bytes, name) == "webp") return webp_info(bytes, name);
    const OpenPicture p = open_picture(bytes, name);
    return {p.spec.width, p.spec.height, p.spec.channelnames, format_read(p)};
  }

  Texture read(std::span<const std::byte> bytes, const std::string& name, const Progress& progress,
               NotFinite not_finite, const std::string& layer) const override {
    if (picture_format(bytes, name) != "webp")
      return read_by_openimageio(bytes, name, progress, not_finite, layer);
    if (!layer.empty())
      throw InvalidInput(fmt::format("{}: has no layer '{}', as webp knows no layers; leave it out", name, layer));
    return read_webp(bytes, name, progress);
  }

  EncodedPicture encode(const Texture& texture, const std::string& name,
                        const std::string& file_format, const Progress& progress) const override {
    const FileFormat& format = format_named(file_format);
    return format.name == "webp" ? webp_bytes(texture, name, format, progress)
                                 : encode_picture(texture, name, format, progress);
  }

  PixelFormat named_channels(const std::vector<std::string>& names, Depth depth) const override {
    OIIO::ImageSpec spec(1, 1, int(names.size()), type_of(depth));
    spec.channelnames = names;
    spec.alpha_channel = -1;
    return {depth, "openexr", std::make_shared<const OIIO::ImageSpec>(spec)};
  }

  bool is_light(const PixelFormat& format) const override { return mq::is_light(format); }
  int orientation(const PixelFormat& format) const override { return stored_orientation(format); }
  std::string foreign_profile(const PixelFormat& format) const override { return foreign_profile_name(format); }
  PixelFormat upright(const PixelFormat& format) const override { return upright_format(format); }

 private:
  static Texture read_by_openimageio(std::span<const std::byte> bytes, const std::string& name,
                                     const Progress& progress, NotFinite not_finite,
                                     const std::string& layer) {
    OpenPicture p = open_picture(bytes, name, layer);
    Texture texture;
    texture.format = format_read(p);
    if (p.layers.size() > 1) texture.format.layers = layers_read(p, bytes);
    try {
      texture.pixels = read_pixels(p, progress, not_finite);
    } catch (const std::bad_alloc&) {
      fail_picture(
          name, fmt::format("{} x {} pixels with {} channels do not fit into memory; scale it down",
                            p.spec.width, p.spec.height, p.spec.nchannels));
    }
    if (p.file_format != "openexr" && p.input->seek_subimage(1, 0))
      p.notes.push_back(name +
                        ": holds several pictures; the first is used, the others are not kept");
    texture.notes = std::move(p.notes);
    return texture;
  }

  static std::shared_ptr<const PictureLayers> layers_read(const OpenPicture& p, std::span<const std::byte> bytes) {
    auto layers = std::make_shared<PictureLayers>();
    for (const FileLayer& layer : p.layers) layers->names.push_back(layer.name);
    layers->chosen = p.layer;
    layers->file = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
    return layers;
  }
};

}  // namespace
}  // namespace mq

extern "C" const mq::PictureCodec* marquetry_picture_codec(const char* version) {
  static const mq::OpenImageIoCodec codec;
  return std::string_view(version) == MARQUETRY_VERSION ? &codec : nullptr;
}
