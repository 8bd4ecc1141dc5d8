// OpenImageIO decodes in memory; what it would do silently is decided here. The format is found by
// content, not by name; sizes are checked before anything is allocated; values are converted here,
// so that reading is exactly value / largest.

#include "mq/io/detail/picture_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <sstream>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_alpha.h"
#include "mq/io/detail/picture_head.h"
#include "mq/io/detail/picture_metadata.h"
#include "mq/io/detail/picture_values.h"
#include "mq/io/image_file.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;

/// The most values a byte of a file can stand for. Deflate makes 1032 bytes of one, or 8256 values
/// of one bit; a fax row and a flat block of EXR take a bit or two whatever their size. A head that
/// promises more is not to be believed, and its pixels are not allocated.
std::size_t max_expansion(const std::string& file_format) {
  return file_format == "tiff" || file_format == "openexr" ? 300000 : 10000;
}

void check_size(const OpenPicture& p, const ImageSpec& s, std::size_t file_bytes) {
  if (s.width < 1 || s.height < 1 || s.depth > 1)
    fail_picture(p.name, fmt::format("{} x {} x {} pixels; a flat picture was expected", s.width,
                                     s.height, s.depth));
  if (s.width > max_picture_side || s.height > max_picture_side)
    fail_too_large(p.name, s.width, s.height);
  const std::size_t raw = std::size_t(s.width) * s.height * s.nchannels;
  if (raw / max_expansion(p.file_format) > file_bytes)
    fail_picture(p.name, fmt::format("cut short or damaged: {} bytes cannot hold {} x {} pixels",
                                     file_bytes, s.width, s.height));
}

void check_kind(const OpenPicture& p) {
  const ImageSpec& s = p.spec;
  if (s.nchannels < 1) fail_picture(p.name, "no channels");
  const bool cmyk = s.get_string_attribute("jpeg:ColorSpace") == "CMYK" ||
                    s.get_string_attribute("tiff:ColorSpace") == "CMYK" ||
                    s.get_int_attribute("tiff:PhotometricInterpretation") == 5;
  if (cmyk)
    fail_picture(p.name, "CMYK colours, which mean nothing without their press; convert it to RGB");
  auto formats = s.channelformats;
  formats.push_back(s.format);
  for (const TypeDesc& f : formats)
    if (f != TypeDesc::UINT8 && f != TypeDesc::UINT16 && f != TypeDesc::HALF &&
        f != TypeDesc::FLOAT && f != TypeDesc::DOUBLE)
      fail_picture(p.name,
                   fmt::format("channels of type {}; 8 and 16 bit unsigned and floating point can "
                               "be used: convert it",
                               f.c_str()));
}

/// While it lives, libpng's lines do not reach standard error, where OpenImageIO lets it print what
/// it returns as well. What others print there meanwhile is passed on at its end.
class SilentPng {
 public:
  explicit SilentPng(const OpenPicture& p) {
    if (p.file_format != "png") return;
    std::fflush(stderr);
    printed_ = ::memfd_create("printed", MFD_CLOEXEC);
    stderr_ = printed_ < 0 ? -1 : ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (stderr_ >= 0) ::dup2(printed_, STDERR_FILENO);
  }
  ~SilentPng() {
    if (stderr_ >= 0) {
      std::fflush(stderr);
      ::dup2(stderr_, STDERR_FILENO);
      ::close(stderr_);
      pass_on();
    }
    if (printed_ >= 0) ::close(printed_);
  }
  SilentPng(const SilentPng&) = delete;
  SilentPng& operator=(const SilentPng&) = delete;

 private:
  void pass_on() const {
    std::string text(std::size_t(std::max<off_t>(0, ::lseek(printed_, 0, SEEK_END))), '\0');
    text.resize(std::size_t(std::max<ssize_t>(0, ::pread(printed_, text.data(), text.size(), 0))));
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
      if (!line.starts_with("libpng ")) std::fputs((line + "\n").c_str(), stderr);
  }

  int printed_ = -1, stderr_ = -1;
};

template <class Stored>
void convert(std::span<const Stored> from, std::span<float> to) {
  constexpr float largest = float(std::numeric_limits<Stored>::max());
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = float(from[i]) / largest;
}

bool read_rows(OpenPicture& p, int begin, int end, TypeDesc type, void* to) {
  const ImageSpec& s = p.spec;
  const SilentPng silent(p);
  const bool alone = p.layers.size() < 2;
  const int part = alone ? 0 : p.layers[p.layer].part, first = alone ? 0 : p.layers[p.layer].first;
  const int last = first + s.nchannels;
  if (s.tile_width == 0)
    return p.input->read_scanlines(part, 0, s.y + begin, s.y + end, 0, first, last, type, to);
  return p.input->read_tiles(part, 0, s.x, s.x + s.width, s.y + begin, s.y + end, 0, 1, first, last, type,
                             to);
}

/// Finds the layer that is meant, and makes its head the picture's.
void choose_layer(OpenPicture& p, const std::string& layer, std::size_t file_bytes) {
  if (p.file_format != "openexr") {
    if (!layer.empty())
      throw InvalidInput(fmt::format("{}: has no layer '{}', as {} knows no layers; leave it out", p.name, layer,
                                     p.file_format));
    if (p.spec.deep) fail_picture(p.name, "a deep image; flatten it first");
    return;
  }
  const std::vector<ImageSpec> parts = heads_of(*p.input);
  for (const ImageSpec& part : parts) {
    if (part.deep)
      fail_picture(p.name, parts.size() > 1 ? "a part of it is a deep image; flatten it first"
                                            : "a deep image; flatten it first");
    if (part.nchannels < 1) fail_picture(p.name, "no channels");
    check_size(p, part, file_bytes);
  }
  p.layers = layers_of(parts);
  p.layer = layer_named(p.layers, layer, p.name);
  const FileLayer& chosen = p.layers[p.layer];
  if (p.layers.size() > 1) p.spec = head_of_layer(parts[std::size_t(chosen.part)], chosen);
}

}  // namespace

std::string explain(const std::string& error) {
  std::string line = error.substr(0, error.find('\n'));
  return line.empty() ? "no reason given" : line;
}

OpenPicture open_picture(ByteView bytes, const std::string& name, const std::string& layer) {
  OpenPicture p;
  p.name = name;
  p.file_format = picture_format(bytes, name);
  const bool colour = p.file_format != "png" || png_states_colour(bytes, name);
  if (p.file_format == "jpeg") check_jpeg_end(bytes, name);
  if (p.file_format == "openexr") check_exr_head(bytes, name);
  if (p.file_format == "tiff") check_tiff_extent(bytes, name);
  SoundPicture sound = without_damaged_metadata(bytes, p.file_format);
  for (const std::string& what : sound.left_out)
    p.notes.push_back(fmt::format("{}: its {} is damaged and was left out", name, what));
  p.sound = std::move(sound.changed);
  if (!p.sound.empty()) bytes = p.sound;
  p.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes.data(), bytes.size());
  p.input = OIIO::ImageInput::create(p.file_format);
  if (!p.input)
    throw Unsupported(
        fmt::format("{}: this build cannot read {}; convert it to PNG", name, p.file_format));
  ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  p.input->set_ioproxy(p.memory.get());
  const auto open = [&] {
    const SilentPng silent(p);
    return p.input->open("memory." + p.file_format, p.spec, config);
  };
  if (!open())
    fail_picture(name, fmt::format("cannot be read as {}: {}; copy it again or convert it",
                                   p.file_format, explain(p.input->geterror())));
  choose_layer(p, layer, bytes.size());
  check_kind(p);
  check_size(p, p.spec, bytes.size());
  if (p.file_format == "png") keep_png_colour(bytes, p.spec);
  // What is assumed for a file that says nothing must not be written into it.
  if (!colour) p.spec.erase_attribute("oiio:ColorSpace");
  if (p.spec.format == TypeDesc::DOUBLE)
    p.notes.push_back(name + ": 64-bit values are used and written with 32 bits");
  return p;
}

int strip_rows(const ImageSpec& spec) {
  constexpr int rows = 256;
  return spec.tile_height > 0 ? (rows + spec.tile_height - 1) / spec.tile_height * spec.tile_height
                              : rows;
}

Image<float> read_pixels(OpenPicture& p, const Progress& progress, NotFinite not_finite) {
  const ImageSpec& s = p.spec;
  Image<float> pixels(s.width, s.height, s.nchannels);
  const std::size_t row = std::size_t(s.width) * s.nchannels;
  const int rows = strip_rows(s);
  const bool bytes = s.format == TypeDesc::UINT8, words = s.format == TypeDesc::UINT16;
  const bool associated = is_associated(s, p.file_format);
  std::vector<std::uint16_t> stored(bytes || words ? row * std::min(rows, s.height) : 0);
  for (int y = 0; y < s.height; y += rows) {
    const int end = std::min(y + rows, s.height);
    const std::size_t first = row * y, count = row * (end - y);
    const std::span<float> to = pixels.values().subspan(first, count);
    const TypeDesc type = bytes ? TypeDesc::UINT8 : words ? TypeDesc::UINT16 : TypeDesc::FLOAT;
    void* target = bytes || words ? static_cast<void*>(stored.data()) : to.data();
    if (!read_rows(p, y, end, type, target))
      fail_picture(p.name,
                   fmt::format("cut short or damaged at rows {} to {} of {}: {}; copy it again", y,
                               end - 1, s.height, explain(p.input->geterror())));
    if (bytes)
      convert(std::span(reinterpret_cast<const std::uint8_t*>(stored.data()), count), to);
    else if (words)
      convert(std::span(std::as_const(stored)).first(count), to);
    if (associated) divide_by_alpha(to, s.nchannels);
    if (!bytes && !words && not_finite == NotFinite::refuse)
      check_finite(p.name, pixels, first, first + count, "repair the picture");
    progress.at(double(end) / s.height);
  }
  return pixels;
}

PixelFormat format_read(const OpenPicture& p) {
  return {depth_of(p.spec.format), p.file_format, std::make_shared<const ImageSpec>(p.spec)};
}

}  // namespace mq
