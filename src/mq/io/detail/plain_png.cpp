// libpng leaves what it finds wrong by longjmp, so between setjmp and there nothing may stand that
// has to be destroyed.

#include "mq/io/detail/plain_png.h"

#include <png.h>
#include <tbb/task_group.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <string_view>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/io/detail/picture_values.h"
#include "mq/io/detail/png_strips.h"

namespace mq {
namespace {

using Byte = std::uint8_t;

constexpr std::string_view signature("\x89PNG\r\n\x1a\n", 8);
constexpr int rows_at_once = 256;    // are turned into values, between reports
constexpr int strips_at_once = 128;  // are compressed, between reports
constexpr std::size_t most_expansion = 1032;  // bytes that deflate makes of one
constexpr int compression = 4;  // in less than half the time of the usual 6; files are 1.5 % larger

struct Head {
  int width = 0, height = 0, channels = 0, value_bytes = 0;
  std::size_t row_bytes() const { return std::size_t(width) * channels * value_bytes; }
  Depth depth() const { return value_bytes == 1 ? Depth::u8 : Depth::u16; }
};

/// The head chunk's contents; whether they are those of a plain file.
bool take_head(std::span<const Byte> chunk, Head& head) {
  if (chunk.size() != 13) return false;
  const std::uint32_t width = png_get_uint_32(chunk.data()),
                      height = png_get_uint_32(chunk.data() + 4);
  const int bits = chunk[8], kind = chunk[9];
  if (width < 1 || height < 1 || width > max_picture_side || height > max_picture_side)
    return false;
  if ((bits != 8 && bits != 16) || chunk[10] != 0 || chunk[11] != 0 || chunk[12] != 0) return false;
  head.channels = kind == PNG_COLOR_TYPE_GRAY         ? 1
                  : kind == PNG_COLOR_TYPE_GRAY_ALPHA ? 2
                  : kind == PNG_COLOR_TYPE_RGB        ? 3
                  : kind == PNG_COLOR_TYPE_RGB_ALPHA  ? 4
                                                      : 0;
  head.width = int(width), head.height = int(height), head.value_bytes = bits / 8;
  return head.channels > 0;
}

/// Follows the chunks to the end; nothing where the file is not a plain one.
std::optional<Head> head_of(std::span<const std::byte> bytes) {
  const auto* const all = reinterpret_cast<const Byte*>(bytes.data());
  if (bytes.size() < signature.size() || std::memcmp(all, signature.data(), signature.size()) != 0)
    return {};
  Head head;
  std::size_t held = 0;
  for (std::size_t at = signature.size(); bytes.size() - at >= 12;) {
    const std::size_t length = png_get_uint_32(all + at);
    if (bytes.size() - at - 12 < length) return {};
    const std::string_view type(reinterpret_cast<const char*>(all) + at + 4, 4);
    const std::span<const Byte> chunk(all + at + 8, length);
    const bool first = head.channels == 0;
    if (first != (type == "IHDR")) return {};
    if (first) {
      if (!take_head(chunk, head)) return {};
    } else if (type == "IDAT") {
      held += length;
    } else if (type == "oFFs") {
      if (std::ranges::any_of(chunk, [](Byte b) { return b != 0; })) return {};
    } else {
      const std::size_t raw = (head.row_bytes() + 1) * std::size_t(head.height);
      if (type != "IEND" || raw / most_expansion > held) return {};
      return head;
    }
    at += 12 + length;
  }
  return {};
}

[[noreturn]] void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }

/// A file that libpng complains of is left to others as well.
void note(png_structp png, png_const_charp) { *static_cast<bool*>(png_get_error_ptr(png)) = true; }

// ------------------------------------------------------------------------------------------
// reading

struct Source {
  std::span<const std::byte> bytes;
  std::size_t at = 0;
};

void take_bytes(png_structp png, png_bytep to, std::size_t count) {
  Source& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (source.bytes.size() - source.at < count) png_error(png, "cut short");
  std::memcpy(to, source.bytes.data() + source.at, count);
  source.at += count;
}

/// The rows of a plain file one after the other.
class PngReader {
 public:
  explicit PngReader(std::span<const std::byte> bytes)
      : source_{bytes},
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &is_odd_, leave, note)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) throw IoError("no memory to read a picture");
    png_set_read_fn(png_, &source_, take_bytes);
    png_set_user_limits(png_, max_picture_side, max_picture_side);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // False where something is wrong.
  bool begin() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_info(png_, info_);
    return !is_odd_;
  }
  bool read(Byte* row) {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_row(png_, row, nullptr);
    return !is_odd_;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_end(png_, nullptr);
    return !is_odd_;
  }

 private:
  bool is_odd_ = false;
  Source source_;
  png_structp png_;
  png_infop info_;
};

// ------------------------------------------------------------------------------------------
// writing

void give_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto& to = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  bool held = true;
  try {
    const auto* const p = reinterpret_cast<const std::byte*>(bytes);
    to.insert(to.end(), p, p + count);
  } catch (const std::bad_alloc&) {
    held = false;
  }
  if (!held) png_error(png, "no memory");
}

class PngWriter {
 public:
  explicit PngWriter(std::vector<std::byte>& to)
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &is_odd_, leave, note)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) throw IoError("no memory to write a picture");
    png_set_write_fn(png_, &to, give_bytes, nullptr);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  void begin(int width, int height, int channels, int value_bytes) {
    constexpr std::array<int, 4> kinds = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                          PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    if (setjmp(png_jmpbuf(png_))) fail();
    png_set_user_limits(png_, max_picture_side, max_picture_side);
    png_set_IHDR(png_, info_, png_uint_32(width), png_uint_32(height), 8 * value_bytes,
                 kinds[std::size_t(channels) - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
  }
  /// `type`: four letters.
  void chunk(const char* type, std::span<const Byte> bytes) {
    if (setjmp(png_jmpbuf(png_))) fail();
    png_write_chunk(png_, reinterpret_cast<png_const_bytep>(type), bytes.data(), bytes.size());
  }

 private:
  [[noreturn]] static void fail() { throw IoError("a picture could not be compressed"); }

  bool is_odd_ = false;
  png_structp png_;
  png_infop info_;
};

// -------------------------------------------------------------------------------------------
// values

void to_floats(const Byte* row, int value_bytes, std::span<float> to) {
  if (value_bytes == 1)
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = float(row[i]) / 255.0F;
  else
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i] = float(row[2 * i] << 8 | row[2 * i + 1]) / 65535.0F;
}

/// The bytes of a row as a file has them. Returns how many values were clamped.
std::int64_t to_bytes(std::span<const float> values, int value_bytes,
                      std::vector<std::byte>& stored, Byte* row) {
  if (value_bytes == 1) {
    const std::int64_t clamped = quantise<std::uint8_t>(values, stored);
    std::memcpy(row, stored.data(), stored.size());
    return clamped;
  }
  const std::int64_t clamped = quantise<std::uint16_t>(values, stored);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint16_t value;
    std::memcpy(&value, stored.data() + 2 * i, 2);
    row[2 * i] = Byte(value >> 8), row[2 * i + 1] = Byte(value & 255);
  }
  return clamped;
}

void append_big_endian(std::uint32_t value, std::vector<Byte>& to) {
  to.resize(to.size() + 4);
  png_save_uint_32(to.data() + to.size() - 4, value);
}

std::size_t compressed_size(std::span<const Byte> bytes, int strategy) {
  constexpr int window_bits = 15, memory_level = 8;  // as libpng has them
  z_stream stream{};
  if (deflateInit2(&stream, compression, Z_DEFLATED, window_bits, memory_level, strategy) != Z_OK)
    throw IoError("no memory to write a picture");
  std::vector<Byte> room(deflateBound(&stream, uLong(bytes.size())));
  stream.next_in = const_cast<Byte*>(bytes.data());
  stream.avail_in = uInt(bytes.size());
  stream.next_out = room.data();
  stream.avail_out = uInt(room.size());
  deflate(&stream, Z_FINISH);
  deflateEnd(&stream);
  return std::size_t(stream.total_out);
}

/// Noise, and most photographs, hold little that comes again but runs of a value: to look for more takes three times
/// as long. Told by a few rows of three places, as differences from pixel to pixel.
int strategy_for(const Image<float>& pixels, int value_bytes) {
  constexpr int places = 3, rows = 8;
  constexpr double most = 1.01;  // times the size of what is looked for in full
  const std::size_t row_values = std::size_t(pixels.width()) * pixels.channels();
  const std::size_t row_bytes = row_values * value_bytes, pixel_bytes = std::size_t(pixels.channels()) * value_bytes;
  std::vector<Byte> row(row_bytes), sample;
  std::vector<std::byte> stored;
  for (int place = 0; place < places; ++place) {
    const int first = int(std::int64_t(pixels.height()) * (2 * place + 1) / (2 * places));
    for (int y = first; y < std::min(first + rows, pixels.height()); ++y) {
      to_bytes(pixels.values().subspan(row_values * y, row_values), value_bytes, stored, row.data());
      for (std::size_t i = 0; i < row_bytes; ++i)
        sample.push_back(Byte(row[i] - (i < pixel_bytes ? 0 : row[i - pixel_bytes])));
    }
  }
  const auto size = [&](int strategy) { return double(compressed_size(sample, strategy)); };
  return size(Z_RLE) <= most * size(Z_FILTERED) ? Z_RLE : Z_FILTERED;
}

/// Those that were not waited for are given up and ended at the end of the scope.
class Tasks {
 public:
  Tasks() = default;
  ~Tasks() {
    if (waited_) return;
    group_.cancel();
    try {
      group_.wait();
    } catch (...) {  // what is left by has its own reason, or is found wrong by another reader
    }
  }
  Tasks(const Tasks&) = delete;
  Tasks& operator=(const Tasks&) = delete;

  template <class Task>
  void run(const Task& task) {
    group_.run(task);
  }
  /// Throws what one of them threw.
  void wait() {
    waited_ = true;
    group_.wait();
  }

 private:
  tbb::task_group group_;
  bool waited_ = false;
};

}  // namespace

std::optional<PictureInfo> plain_png_info(std::span<const std::byte> bytes) {
  const std::optional<Head> head = head_of(bytes);
  if (!head) return {};
  static const std::array<std::vector<std::string>, 4> names = {
      {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}};
  return PictureInfo{head->width,
                     head->height,
                     names[std::size_t(head->channels) - 1],
                     {head->depth(), "png", nullptr}};
}

std::optional<Texture> read_plain_png(std::span<const std::byte> bytes, const Progress& progress) {
  const std::optional<Head> head = head_of(bytes);
  if (!head) return {};
  Texture texture;
  texture.format = {head->depth(), "png", nullptr};
  const std::size_t row_values = std::size_t(head->width) * head->channels;
  PngReader reader(bytes);
  if (!reader.begin()) return {};
  std::once_flag made;
  Tasks to_values;  // of rows, while the next are decompressed
  for (int first = 0; first < head->height; first += rows_at_once) {
    const int count = std::min(rows_at_once, head->height - first);
    auto rows = std::make_shared<std::vector<Byte>>(head->row_bytes() * std::size_t(count));
    for (int i = 0; i < count; ++i)
      if (!reader.read(rows->data() + head->row_bytes() * std::size_t(i))) return {};
    to_values.run([&, rows, first, count] {
      std::call_once(made, [&] { texture.pixels = Image<float>(head->width, head->height, head->channels); });
      for (int i = 0; i < count; ++i)
        to_floats(rows->data() + head->row_bytes() * std::size_t(i), head->value_bytes,
                  texture.pixels.values().subspan(row_values * std::size_t(first + i), row_values));
    });
    progress.at(double(first + count) / head->height);
  }
  to_values.wait();
  if (!reader.end()) return {};
  return texture;
}

bool fits_plain_png(const Texture& texture, const FileFormat& format) {
  return format.name == "png" && texture.format.tags == nullptr;
}

EncodedPicture plain_png_bytes(const Texture& texture, const std::string& name,
                               const FileFormat& format, const Progress& progress) {
  check_writable(texture, name, format);
  const Image<float>& pixels = texture.pixels;
  const Depth depth = format.depth[std::size_t(texture.format.depth)];
  const int channels = pixels.channels(), value_bytes = depth == Depth::u8 ? 1 : 2;
  const std::size_t row_values = std::size_t(pixels.width()) * channels;
  EncodedPicture encoded;
  PngWriter writer(encoded.bytes);
  writer.begin(pixels.width(), pixels.height(), channels, value_bytes);
  const PngStrips strips(pixels.height(), row_values * value_bytes, channels * value_bytes, compression,
                         strategy_for(pixels, value_bytes));
  std::int64_t clamped = 0;
  std::uint32_t sum = 1;
  for (int first = 0; first < strips.count(); first += strips_at_once) {
    const int count = std::min(strips_at_once, strips.count() - first);
    std::vector<PngStrips::Strip> some(count);
    clamped += parallel_sum(count, std::int64_t(0), [&](std::int64_t i, std::int64_t) {
      const int strip = first + int(i);
      std::vector<std::byte> stored;
      std::int64_t clamped_here = 0;
      some[i] = strips.compress(strip, [&](int y, Byte* to) {
        const std::int64_t in_row =
            to_bytes(pixels.values().subspan(row_values * std::size_t(y), row_values), value_bytes, stored, to);
        if (y >= strips.begin(strip)) clamped_here += in_row;
      });
      return clamped_here;
    }, 1);
    for (PngStrips::Strip& strip : some) {
      sum = PngStrips::sum(sum, strip);
      if (first + count == strips.count() && &strip == &some.back()) append_big_endian(sum, strip.bytes);
      writer.chunk("IDAT", strip.bytes);
    }
    progress.at(double(strips.end(first + count - 1)) / pixels.height());
  }
  writer.chunk("IEND", {});
  encoded.notes = notes_on(name, texture, format, depth, clamped, false);
  return encoded;
}

}  // namespace mq
