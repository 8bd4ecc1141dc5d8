// OpenImageIO encodes in memory; what it would do silently is decided here. Values are converted
// here, so that writing rounds to nearest and refuses NaN.

#include "mq/io/detail/picture_writer.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_alpha.h"
#include "mq/io/detail/picture_head.h"
#include "mq/io/detail/picture_layers.h"
#include "mq/io/detail/picture_memory.h"
#include "mq/io/detail/picture_metadata.h"
#include "mq/io/detail/picture_reader.h"
#include "mq/io/detail/picture_values.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;

constexpr float largest_half = 65504;

std::int64_t limit(std::span<const float> from, float largest, std::vector<std::byte>& to) {
  to.resize(from.size() * sizeof(float));
  auto* stored = reinterpret_cast<float*>(to.data());
  std::int64_t clamped = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    clamped += std::abs(from[i]) > largest;
    stored[i] = std::clamp(from[i], -largest, largest);
  }
  return clamped;
}

struct Strip {
  TypeDesc type;
  std::vector<std::byte> bytes;
  std::int64_t clamped = 0;
};

void fill(Strip& strip, std::span<const float> values, Depth depth) {
  strip.type = depth == Depth::half ? TypeDesc::FLOAT : type_of(depth);
  if (depth == Depth::u8)
    strip.clamped += quantise<std::uint8_t>(values, strip.bytes);
  else if (depth == Depth::u16)
    strip.clamped += quantise<std::uint16_t>(values, strip.bytes);
  else
    strip.clamped +=
        limit(values, depth == Depth::half ? largest_half : std::numeric_limits<float>::max(),
              strip.bytes);
}

EncodedPicture among_layers(const Texture& texture, const std::string& name, const FileFormat& format,
                            Depth depth, const Progress& progress) {
  std::int64_t clamped = 0;
  EncodedPicture encoded = encode_among_layers(texture, name, depth, clamped, progress);
  for (std::string& note : notes_on(name, texture, format, depth, clamped, is_light(texture.format)))
    encoded.notes.push_back(std::move(note));
  return encoded;
}

std::string other_layers_note(const Texture& texture, const std::string& name, const FileFormat& format) {
  const PictureLayers& layers = *texture.format.layers;
  return fmt::format("{}: holds the layer {} alone; {} other{} left behind, as {}", name,
                     shown(layers.names[layers.chosen]), layers.names.size() - 1,
                     layers.names.size() == 2 ? " is" : "s are",
                     format.name == "openexr" ? "its size or its channels are not theirs any more"
                                              : fmt::format("{} knows no layers", format.name));
}

}  // namespace

EncodedPicture encode_picture(const Texture& texture, const std::string& name,
                              const FileFormat& format, const Progress& progress) {
  check_writable(texture, name, format);
  const Image<float>& pixels = texture.pixels;
  const Depth depth = format.depth[std::size_t(texture.format.depth)];
  // Debian's build of it tells standard error which tags a format does not know.
  [[maybe_unused]] static const bool is_silent = OIIO::attribute("debug", 0);
  if (format.name == "openexr" && fits_its_layer(texture)) return among_layers(texture, name, format, depth, progress);
  const ImageSpec spec = spec_for(texture, format, depth);
  const auto output = OIIO::ImageOutput::create(std::string(format.name));
  if (!output)
    throw Unsupported(
        fmt::format("{}: this build cannot write {}; choose .png", name, format.name));
  std::optional<MemoryFile> file;
  std::vector<unsigned char> written;
  OIIO::Filesystem::IOVecOutput memory(written);
  if (format.name == "tiff")
    file.emplace();
  else
    output->set_ioproxy(&memory);
  const auto check = [&](bool ok) {
    if (!ok)
      fail_picture(name, fmt::format("cannot be written as {}: {}", format.name,
                                     explain(output->geterror())));
  };
  check(output->open(file ? file->name() : fmt::format("memory.{}", format.name), spec));
  Strip strip;
  const std::size_t row = std::size_t(spec.width) * spec.nchannels;
  const int rows = strip_rows(spec);
  const bool associated = is_associated(spec, std::string(format.name));
  for (int y = 0; y < spec.height; y += rows) {
    const int end = std::min(y + rows, spec.height);
    const std::span<const float> values = pixels.values().subspan(row * y, row * (end - y));
    fill(strip, associated ? multiplied_by_alpha(values, spec.nchannels) : values, depth);
    check(output->write_scanlines(spec.y + y, spec.y + end, 0, strip.type, strip.bytes.data()));
    progress.at(double(end) / spec.height);
  }
  check(output->close());
  EncodedPicture encoded;
  if (file) {
    encoded.bytes = file->bytes();
    open_picture(encoded.bytes, name);  // a head that cannot be read says that something is missing
  } else {
    encoded.bytes.resize(written.size());
    std::memcpy(encoded.bytes.data(), written.data(), written.size());
    if (format.name == "png") encoded.bytes = with_png_colour(encoded.bytes, png_colour_for(texture));
  }
  encoded.notes =
      notes_on(name, texture, format, depth, strip.clamped, is_light(texture.format));
  if (texture.format.layers) encoded.notes.push_back(other_layers_note(texture, name, format));
  return encoded;
}

}  // namespace mq
