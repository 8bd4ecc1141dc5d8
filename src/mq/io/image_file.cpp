// OpenImageIO decodes and encodes in memory; what it would do silently is decided here. The format
// is found by content, not by name; sizes are checked before anything is allocated; values are
// converted here, so that reading is exactly value / largest and writing rounds to nearest and
// refuses NaN.

#include "mq/io/image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <optional>
#include <sstream>
#include <string_view>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/io/detail/fingerprint.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

using Bytes = std::span<const std::byte>;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

struct FileFormat {
  std::string_view name;  ///< as OpenImageIO calls it
  std::vector<std::string_view> extensions;
  int max_channels;
  std::array<Depth, 4> depth;  ///< how it stores a u8, u16, half, f32
};

const std::array<FileFormat, 6>& file_formats() {
  using enum Depth;
  constexpr int any = 1024;
  static const std::array<FileFormat, 6> formats = {{
      {"png", {".png"}, 4, {u8, u16, u16, u16}},
      {"jpeg", {".jpg", ".jpeg"}, 3, {u8, u8, u8, u8}},
      {"tiff", {".tif", ".tiff"}, any, {u8, u16, f32, f32}},
      {"openexr", {".exr"}, any, {half, f32, half, f32}},
      {"bmp", {".bmp"}, 4, {u8, u8, u8, u8}},
      {"targa", {".tga"}, 4, {u8, u8, u8, u8}},
  }};
  return formats;
}

const FileFormat& format_named(const std::string& name) {
  for (const FileFormat& f : file_formats())
    if (f.name == name) return f;
  throw InvalidInput(
      fmt::format("unknown picture format \"{}\": {} can be written", name, known_picture_formats));
}

const FileFormat* format_of_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const FileFormat& f : file_formats())
    if (std::ranges::find(f.extensions, extension) != f.extensions.end()) return &f;
  return nullptr;
}

// ---- Alpha ------------------------------------------------------------------------------------

/// Alpha is the last of two or four channels where the file says so.
bool has_alpha(const ImageSpec& spec) {
  return (spec.nchannels == 2 || spec.nchannels == 4) && spec.alpha_channel == spec.nchannels - 1;
}

/// Whether colours lie in the file multiplied by alpha: always in OpenEXR, in TIFF and TGA where
/// they do not say otherwise. PNG and BMP know no such thing.
bool is_associated(const ImageSpec& spec, const std::string& file_format) {
  const bool can = file_format == "openexr" || file_format == "tiff" || file_format == "targa";
  return can && has_alpha(spec) && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
}

/// A pixel of less alpha shows nothing, and its colours are kept as they lie in the file. Far below
/// what 16-bit floating point can hold.
constexpr float least_alpha = 1e-9F;

void divide_by_alpha(std::span<float> values, int channels) {
  for (std::size_t i = 0; i < values.size(); i += channels)
    if (const float alpha = values[i + channels - 1]; alpha > least_alpha)
      for (int c = 0; c < channels - 1; ++c) values[i + c] /= alpha;
}

std::vector<float> multiplied_by_alpha(std::span<const float> values, int channels) {
  std::vector<float> result(values.begin(), values.end());
  for (std::size_t i = 0; i < result.size(); i += channels)
    if (const float alpha = result[i + channels - 1]; alpha > least_alpha)
      for (int c = 0; c < channels - 1; ++c) result[i + c] *= alpha;
  return result;
}

// ---- Reading ----------------------------------------------------------------------------------

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    fail_picture(name, name.find('%') == name.npos
                           ? "no such file; check the name"
                           : "no such file; names of frames are filled in where --frames is given");
  if (std::filesystem::is_directory(status))
    fail_picture(name, "a directory; a picture was expected");
  if (!std::filesystem::is_regular_file(status))
    fail_picture(name, "not an ordinary file; a picture was expected");
  std::ifstream in(path, std::ios::binary);
  if (!in)
    fail_picture(name,
                 fmt::format("cannot be read: {}; check its permissions", std::strerror(errno)));
  std::vector<std::byte> bytes(std::filesystem::file_size(path));
  in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
  if (std::size_t(in.gcount()) != bytes.size())
    fail_picture(name, fmt::format("only {} of {} bytes could be read", in.gcount(), bytes.size()));
  return bytes;
}

struct OpenPicture {
  std::string name;
  std::string file_format;
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;  // outlives `input`
  std::unique_ptr<OIIO::ImageInput> input;
  ImageSpec spec;
  std::vector<std::string> notes;
};

std::string explain(const std::string& error) {
  std::string line = error.substr(0, error.find('\n'));
  return line.empty() ? "no reason given" : line;
}

/// The most values a byte of a file can stand for. Deflate makes 1032 bytes of one, or 8256 values
/// of one bit; a fax row and a flat block of EXR take a bit or two whatever their size. A head that
/// promises more is not to be believed, and its pixels are not allocated.
std::size_t max_expansion(const std::string& file_format) {
  return file_format == "tiff" || file_format == "openexr" ? 300000 : 10000;
}

void check_size(const OpenPicture& p, std::size_t file_bytes) {
  const ImageSpec& s = p.spec;
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
  if (s.deep) fail_picture(p.name, "a deep image; flatten it first");
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

Depth depth_of(const TypeDesc& type) {
  if (type == TypeDesc::UINT8) return Depth::u8;
  if (type == TypeDesc::UINT16) return Depth::u16;
  return type == TypeDesc::HALF ? Depth::half : Depth::f32;
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

OpenPicture open_picture(Bytes bytes, const std::string& name) {
  OpenPicture p;
  p.name = name;
  p.file_format = picture_format(bytes, name);
  const bool colour = p.file_format != "png" || png_states_colour(bytes, name);
  if (p.file_format == "jpeg") check_jpeg_end(bytes, name);
  if (p.file_format == "openexr") check_exr_windows(bytes, name);
  if (p.file_format == "tiff") check_tiff_extent(bytes, name);
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
  check_kind(p);
  check_size(p, bytes.size());
  // What is assumed for a file that says nothing must not be written into it.
  if (!colour) p.spec.erase_attribute("oiio:ColorSpace");
  if (p.spec.format == TypeDesc::DOUBLE)
    p.notes.push_back(name + ": 64-bit values are used and written with 32 bits");
  return p;
}

template <class Stored>
void convert(std::span<const Stored> from, std::span<float> to) {
  constexpr float largest = float(std::numeric_limits<Stored>::max());
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = float(from[i]) / largest;
}

[[noreturn]] void fail_not_finite(const std::string& name, const Image<float>& pixels,
                                  std::size_t index, const char* remedy) {
  const std::size_t pixel = index / pixels.channels();
  fail_picture(name, fmt::format("pixel (column {}, row {}) holds {} in channel {}; {}",
                                 pixel % pixels.width(), pixel / pixels.width(),
                                 pixels.values()[index], index % pixels.channels(), remedy));
}

void check_finite(const std::string& name, const Image<float>& pixels, std::size_t begin,
                  std::size_t end, const char* remedy) {
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isfinite(pixels.values()[i])) fail_not_finite(name, pixels, i, remedy);
}

bool read_rows(OpenPicture& p, int begin, int end, TypeDesc type, void* to) {
  const ImageSpec& s = p.spec;
  const SilentPng silent(p);
  if (s.tile_width == 0)
    return p.input->read_scanlines(0, 0, s.y + begin, s.y + end, 0, 0, s.nchannels, type, to);
  return p.input->read_tiles(0, 0, s.x, s.x + s.width, s.y + begin, s.y + end, 0, 1, 0, s.nchannels,
                             type, to);
}

/// Rows decoded at a time: a multiple of every EXR block and of the tiles.
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

// ---- Writing ----------------------------------------------------------------------------------

TypeDesc type_of(Depth depth) {
  switch (depth) {
    case Depth::u8: return TypeDesc::UINT8;
    case Depth::u16: return TypeDesc::UINT16;
    case Depth::half: return TypeDesc::HALF;
    case Depth::f32: break;
  }
  return TypeDesc::FLOAT;
}

const char* words_for(Depth depth) {
  switch (depth) {
    case Depth::u8: return "8 bits per channel";
    case Depth::u16: return "16 bits per channel";
    case Depth::half: return "16-bit floating point";
    case Depth::f32: break;
  }
  return "32-bit floating point";
}

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
  static const std::array<std::string_view, 9> prefixes = {
      "png:",   "jpeg:",       "tiff:",        "openexr:",        "bmp:",
      "targa:", "compression", "screenWindow", "PixelAspectRatio"};
  return std::ranges::any_of(prefixes, [&](std::string_view p) { return tag.starts_with(p); });
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

/// Whether what was read from a file is light, by its tags.
bool is_light(const PixelFormat& format) {
  const auto* read = static_cast<const ImageSpec*>(format.tags.get());
  if (read == nullptr) return false;
  return depth_of(read->format) >= Depth::half ||
         OIIO::Strutil::iequals(read->get_string_attribute("oiio:ColorSpace"), "linear");
}

/// The head of the new file: the one that was read where it fits the pixels, otherwise a plain one.
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
  if (format.name == "jpeg") {
    spec["Compression"] = "jpeg:98";
    spec["jpeg:subsampling"] = "4:4:4";
  }
  return spec;
}

/// Rounds to the nearest stored value. Returns how many lay outside by more than that rounding.
template <class Stored>
std::int64_t quantise(std::span<const float> from, std::vector<std::byte>& to) {
  constexpr float largest = float(std::numeric_limits<Stored>::max());
  to.resize(from.size() * sizeof(Stored));
  auto* stored = reinterpret_cast<Stored*>(to.data());
  std::int64_t clamped = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const float scaled = from[i] * largest;
    clamped += scaled < -0.5f || scaled > largest + 0.5f;
    stored[i] = Stored(std::clamp(scaled, 0.0f, largest) + 0.5f);
  }
  return clamped;
}

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

void check_writable(const Texture& texture, const std::string& name, const FileFormat& format) {
  const Image<float>& pixels = texture.pixels;
  if (pixels.empty()) throw InvalidInput(fmt::format("{}: the picture has no pixels", name));
  if (pixels.channels() > format.max_channels)
    throw InvalidInput(fmt::format("{}: {}, of which {} holds {}; choose .exr or .tif{}", name,
                                   counted(pixels.channels(), "channel"), format.name,
                                   format.max_channels, pixels.channels() <= 4 ? " or .png" : ""));
  if (format.max_channels == 3 && pixels.channels() == 2)
    throw InvalidInput(
        fmt::format("{}: grey with alpha, which jpeg does not hold; choose .png", name));
  check_finite(name, pixels, 0, pixels.values().size(), "nothing was written");
}

std::vector<std::string> notes_on(const std::string& name, const Texture& texture,
                                  const FileFormat& format, Depth depth, std::int64_t clamped) {
  std::vector<std::string> notes;
  const Depth wanted = texture.format.depth;
  const bool loses =
      depth == Depth::u8 ? wanted != depth : depth == Depth::u16 && wanted > Depth::u16;
  if (loses || (wanted == Depth::half && depth == Depth::f32))
    notes.push_back(fmt::format("{}: {} cannot hold {}; written with {}", name, format.name,
                                words_for(wanted), words_for(depth)));
  if (format.name != "openexr" && is_light(texture.format) && depth <= Depth::u16)
    notes.push_back(fmt::format(
        "{}: holds light, {}; write .exr to keep its range", name,
        format.name == "png" ? "and says so by its gamma of 1, which not all programs heed"
                             : "which its format cannot say, so that it will be shown too dark"));
  if (clamped > 0)
    notes.push_back(fmt::format("{}: {} beyond what {} can hold, clamped", name,
                                counted(clamped, "value"), words_for(depth)));
  if (format.name == "jpeg")
    notes.push_back(
        fmt::format("{}: every pixel is encoded again as JPEG (quality 98); write .png "
                    "to keep untouched texels exactly",
                    name));
  return notes;
}

/// Where TIFF is written to: memory that has the name of a file, since libtiff goes back to what it
/// wrote when there are EXIF tags, which OpenImageIO's writer into memory does not let it.
class MemoryFile {
 public:
  MemoryFile() : file_(::memfd_create("picture", MFD_CLOEXEC)) {
    if (file_ < 0) throw IoError(fmt::format("no memory to write to: {}", std::strerror(errno)));
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string name() const { return fmt::format("/proc/self/fd/{}", file_); }

  std::vector<std::byte> bytes() const {
    std::vector<std::byte> all(std::size_t(std::max<off_t>(0, ::lseek(file_, 0, SEEK_END))));
    for (std::size_t done = 0; done < all.size();) {
      const ssize_t got = ::pread(file_, all.data() + done, all.size() - done, off_t(done));
      if (got <= 0) throw IoError("what was encoded cannot be read back");
      done += std::size_t(got);
    }
    return all;
  }

 private:
  int file_;
};

EncodedPicture encode(const Texture& texture, const std::string& name, const FileFormat& format,
                      const Progress& progress) {
  check_writable(texture, name, format);
  const Image<float>& pixels = texture.pixels;
  const Depth depth = format.depth[std::size_t(texture.format.depth)];
  const ImageSpec spec = spec_for(texture, format, depth);
  // Debian's build of it tells standard error which tags a format does not know.
  [[maybe_unused]] static const bool is_silent = OIIO::attribute("debug", 0);
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
  }
  encoded.notes = notes_on(name, texture, format, depth, strip.clamped);
  return encoded;
}

}  // namespace

bool holds_light(const PixelFormat& format) {
  return format.depth == Depth::half || format.depth == Depth::f32 || is_light(format);
}

PixelFormat named_channels(const std::vector<std::string>& names, Depth depth) {
  ImageSpec spec(1, 1, int(names.size()), type_of(depth));
  spec.channelnames = names;
  spec.alpha_channel = -1;
  return {depth, "openexr", std::make_shared<const ImageSpec>(spec)};
}

PictureInfo picture_info(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  const OpenPicture p = open_picture(bytes, path.string());
  return {p.spec.width, p.spec.height, p.spec.channelnames, format_read(p)};
}

Texture read_texture_bytes(Bytes bytes, const std::string& name, const Progress& progress,
                           NotFinite not_finite) {
  OpenPicture p = open_picture(bytes, name);
  Texture texture;
  texture.name = name;
  texture.format = format_read(p);
  try {
    texture.pixels = read_pixels(p, progress, not_finite);
  } catch (const std::bad_alloc&) {
    fail_picture(
        name, fmt::format("{} x {} pixels with {} channels do not fit into memory; scale it down",
                          p.spec.width, p.spec.height, p.spec.nchannels));
  }
  if (p.input->seek_subimage(1, 0))
    p.notes.push_back(name +
                      ": holds several pictures; the first is used, the others are not kept");
  texture.notes = std::move(p.notes);
  texture.as_read = {fingerprint(texture), fingerprint(bytes)};
  return texture;
}

EncodedPicture texture_bytes(const Texture& texture, const std::string& file_format,
                             const Progress& progress) {
  return encode(texture, texture.name, format_named(file_format), progress);
}

Texture read_texture(const std::filesystem::path& path, const Progress& progress,
                     NotFinite not_finite) {
  const std::vector<std::byte> bytes = read_bytes(path);
  Texture texture = read_texture_bytes(bytes, path.string(), progress, not_finite);
  texture.name = path.filename().string();
  texture.path = path;
  return texture;
}

namespace {

/// The format that an extension names. Throws `InvalidInput` where it names none.
const FileFormat* writable_format(const std::filesystem::path& path) {
  const FileFormat* format = format_of_extension(path);
  if (format == nullptr)
    throw InvalidInput(
        fmt::format("{}: the extension names no picture format that can be written; "
                    "use .png, .jpg, .tif, .exr, .bmp or .tga",
                    path.string()));
  return format;
}

/// The file a picture was read from, if it still holds these pixels in this format and depth.
std::vector<std::byte> unchanged_source(const Texture& texture, const FileFormat& format) {
  std::error_code ignored;
  if (texture.path.empty() || texture.format.file_format != format.name ||
      !std::filesystem::is_regular_file(texture.path, ignored))
    return {};
  try {
    std::vector<std::byte> bytes = read_bytes(texture.path);
    return is_as_read(texture, bytes) ? std::move(bytes) : std::vector<std::byte>();
  } catch (const IoError&) {  // it is gone
    return {};
  }
}

}  // namespace

std::vector<std::string> write_texture(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress) {
  const FileFormat* format = writable_format(path);
  if (const auto bytes = unchanged_source(texture, *format); !bytes.empty()) {
    write_file(path, bytes);
    return {};
  }
  return write_encoded(path, texture, progress);
}

std::vector<std::string> write_encoded(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress) {
  const FileFormat* format = writable_format(path);
  const EncodedPicture encoded = encode(texture, path.string(), *format, progress);
  write_file(path, encoded.bytes);
  return encoded.notes;
}

std::vector<std::string> write_image(const std::filesystem::path& path, const Image<float>& pixels,
                                     Depth depth) {
  Texture texture;
  texture.pixels = pixels;
  texture.format.depth = depth;
  return write_texture(path, texture);
}

}  // namespace mq
