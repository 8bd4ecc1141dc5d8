// Rows are filtered as the PNG standard recommends (12.8): each by that of the five filters whose bytes,
// taken as signed, have the least sum of sizes.

#include "mq/io/detail/plain_png.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/detail/picture_values.h"

namespace mq {
namespace {

using Byte = std::uint8_t;

constexpr std::string_view signature("\x89PNG\r\n\x1a\n", 8);
constexpr int rows_per_report = 256;
constexpr std::size_t most_expansion = 1032;  // bytes that deflate makes of one

struct Head {
  int width = 0, height = 0, channels = 0, value_bytes = 0;
  std::vector<std::span<const Byte>> data;  ///< of the IDAT chunks
  std::size_t row_bytes() const { return std::size_t(width) * channels * value_bytes; }
  std::size_t pixel_bytes() const { return std::size_t(channels) * value_bytes; }
  Depth depth() const { return value_bytes == 1 ? Depth::u8 : Depth::u16; }
};

std::uint32_t big_endian(const Byte* p) {
  return std::uint32_t(p[0]) << 24 | std::uint32_t(p[1]) << 16 | std::uint32_t(p[2]) << 8 | p[3];
}

/// The head chunk's contents; whether they are those of a plain file.
bool take_head(std::span<const Byte> chunk, Head& head) {
  if (chunk.size() != 13) return false;
  const std::uint32_t width = big_endian(chunk.data()), height = big_endian(chunk.data() + 4);
  const int bits = chunk[8], kind = chunk[9];
  if (width < 1 || height < 1 || width > max_picture_side || height > max_picture_side) return false;
  if ((bits != 8 && bits != 16) || chunk[10] != 0 || chunk[11] != 0 || chunk[12] != 0) return false;
  head.channels = kind == 0 ? 1 : kind == 2 ? 3 : kind == 4 ? 2 : kind == 6 ? 4 : 0;
  head.width = int(width), head.height = int(height), head.value_bytes = bits / 8;
  return head.channels > 0;
}

/// Follows the chunks to the end; nothing where the file is not a plain one.
std::optional<Head> head_of(std::span<const std::byte> bytes) {
  const auto* const all = reinterpret_cast<const Byte*>(bytes.data());
  if (bytes.size() < signature.size() ||
      std::memcmp(all, signature.data(), signature.size()) != 0)
    return {};
  Head head;
  std::size_t held = 0;
  for (std::size_t at = signature.size(); bytes.size() - at >= 12;) {
    const std::size_t length = big_endian(all + at);
    if (bytes.size() - at - 12 < length) return {};
    const std::string_view type(reinterpret_cast<const char*>(all) + at + 4, 4);
    const std::span<const Byte> chunk(all + at + 8, length);
    if (crc32(crc32(0, nullptr, 0), all + at + 4, uInt(length + 4)) !=
        big_endian(all + at + 8 + length))
      return {};
    const bool first = head.channels == 0;
    if (first != (type == "IHDR")) return {};
    if (first) {
      if (!take_head(chunk, head)) return {};
    } else if (type == "IDAT") {
      head.data.push_back(chunk);
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

// --------------------------------------------------------------------------------------- filters

int paeth(int a, int b, int c) {
  const int p = a + b - c, pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/// Takes a filter off a row; `above`: the row before, both with `pixel` zeros before them.
bool unfilter(int filter, std::size_t pixel, std::size_t count, const Byte* above, Byte* row) {
  switch (filter) {
    case 0: return true;
    case 1:
      for (std::size_t i = 0; i < count; ++i) row[i] = Byte(row[i] + row[i - pixel]);
      return true;
    case 2:
      for (std::size_t i = 0; i < count; ++i) row[i] = Byte(row[i] + above[i]);
      return true;
    case 3:
      for (std::size_t i = 0; i < count; ++i)
        row[i] = Byte(row[i] + (row[i - pixel] + above[i]) / 2);
      return true;
    case 4:
      for (std::size_t i = 0; i < count; ++i)
        row[i] = Byte(row[i] + paeth(row[i - pixel], above[i], above[i - pixel]));
      return true;
  }
  return false;
}

void apply_filter(int filter, std::size_t pixel, std::size_t count, const Byte* above,
                  const Byte* row, Byte* to) {
  const Byte* const left = row - pixel;
  switch (filter) {
    case 0: std::copy(row, row + count, to); break;
    case 1:
      for (std::size_t i = 0; i < count; ++i) to[i] = Byte(row[i] - left[i]);
      break;
    case 2:
      for (std::size_t i = 0; i < count; ++i) to[i] = Byte(row[i] - above[i]);
      break;
    case 3:
      for (std::size_t i = 0; i < count; ++i) to[i] = Byte(row[i] - (left[i] + above[i]) / 2);
      break;
    default:
      for (std::size_t i = 0; i < count; ++i)
        to[i] = Byte(row[i] - paeth(left[i], above[i], above[i - pixel]));
  }
}

std::uint64_t size_of_bytes(const Byte* bytes, std::size_t count) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += std::min<unsigned>(bytes[i], 256U - bytes[i]);
  return sum;
}

/// A row and the one above it, each with zeros in the place of a pixel before it.
class TwoRows {
 public:
  TwoRows(std::size_t pixel, std::size_t count)
      : pixel_(pixel), above_(pixel + count, 0), row_(pixel + count, 0) {}
  Byte* row() { return row_.data() + pixel_; }
  const Byte* above() const { return above_.data() + pixel_; }
  void next() { std::swap(row_, above_); }

 private:
  std::size_t pixel_;
  std::vector<Byte> above_, row_;
};

// ------------------------------------------------------------------------------------------ zlib

/// The bytes of IDAT chunks, inflated piece by piece.
class Inflater {
 public:
  explicit Inflater(const Head& head) : head_(head) { ready_ = inflateInit(&stream_) == Z_OK; }
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool take(Byte* to, std::size_t count) {
    stream_.next_out = to;
    stream_.avail_out = uInt(count);
    while (ready_ && stream_.avail_out > 0)
      if (!step()) return false;
    return ready_;
  }

  /// Whether nothing but the end of the stream is left, with the sum that it states.
  bool at_end() {
    Byte none;
    stream_.next_out = &none;
    stream_.avail_out = 1;
    while (!ended_)
      if (!step() || stream_.avail_out == 0) return false;
    return stream_.avail_in == 0 && next_ == head_.data.size();
  }

 private:
  bool step() {
    while (stream_.avail_in == 0 && next_ < head_.data.size()) {
      stream_.next_in = const_cast<Byte*>(head_.data[next_].data());
      stream_.avail_in = uInt(head_.data[next_++].size());
    }
    if (ended_ || stream_.avail_in == 0) return false;
    const int status = inflate(&stream_, Z_NO_FLUSH);
    ended_ = status == Z_STREAM_END;
    return status == Z_OK || ended_;
  }

  const Head& head_;
  z_stream stream_{};
  std::size_t next_ = 0;
  bool ready_ = false, ended_ = false;
};

/// Chunks of a PNG file, appended to bytes.
class ChunkWriter {
 public:
  explicit ChunkWriter(std::vector<std::byte>& to) : to_(to) {
    const auto* p = reinterpret_cast<const std::byte*>(signature.data());
    to_.insert(to_.end(), p, p + signature.size());
  }

  void add(const char* type, std::span<const Byte> contents) {
    put(std::uint32_t(contents.size()));
    const std::size_t from = to_.size();
    for (int i = 0; i < 4; ++i) to_.push_back(std::byte(type[i]));
    const auto* p = reinterpret_cast<const std::byte*>(contents.data());
    to_.insert(to_.end(), p, p + contents.size());
    put(std::uint32_t(crc32(crc32(0, nullptr, 0), reinterpret_cast<const Byte*>(to_.data()) + from,
                            uInt(to_.size() - from))));
  }

 private:
  void put(std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) to_.push_back(std::byte(value >> shift & 255));
  }

  std::vector<std::byte>& to_;
};

/// IDAT chunks of what is added.
class Deflater {
 public:
  explicit Deflater(ChunkWriter& chunks) : chunks_(chunks), buffer_(std::size_t(1) << 18) {
    constexpr int level = 4;  // in less than half the time of the usual 6; files are 1.5 % larger
    if (deflateInit(&stream_, level) != Z_OK)
      throw IoError("no memory to compress a picture");
    start();
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void add(std::span<const Byte> bytes) {
    stream_.next_in = const_cast<Byte*>(bytes.data());
    stream_.avail_in = uInt(bytes.size());
    while (stream_.avail_in > 0) {
      deflate(&stream_, Z_NO_FLUSH);
      if (stream_.avail_out == 0) hand_over();
    }
  }

  void finish() {
    while (deflate(&stream_, Z_FINISH) != Z_STREAM_END) hand_over();
    hand_over();
  }

 private:
  void start() {
    stream_.next_out = buffer_.data();
    stream_.avail_out = uInt(buffer_.size());
  }
  void hand_over() {
    if (const std::size_t count = buffer_.size() - stream_.avail_out; count > 0)
      chunks_.add("IDAT", std::span(buffer_).first(count));
    start();
  }

  ChunkWriter& chunks_;
  std::vector<Byte> buffer_;
  z_stream stream_{};
};

// ---------------------------------------------------------------------------------------- values

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

/// The row under its best filter, behind the filter's number.
void choose_filter(std::size_t pixel, std::size_t count, TwoRows& rows,
                   std::array<std::vector<Byte>, 2>& tried) {
  std::uint64_t least = ~std::uint64_t(0);
  for (int filter = 0; filter < 5; ++filter) {
    tried[1][0] = Byte(filter);
    apply_filter(filter, pixel, count, rows.above(), rows.row(), tried[1].data() + 1);
    const std::uint64_t size = size_of_bytes(tried[1].data() + 1, count);
    if (size >= least) continue;
    least = size;
    std::swap(tried[0], tried[1]);
  }
}

}  // namespace

std::optional<PictureInfo> plain_png_info(std::span<const std::byte> bytes) {
  const std::optional<Head> head = head_of(bytes);
  if (!head) return {};
  static const std::array<std::vector<std::string>, 4> names = {
      {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}};
  return PictureInfo{head->width, head->height, names[std::size_t(head->channels) - 1],
                     {head->depth(), "png", nullptr}};
}

std::optional<Texture> read_plain_png(std::span<const std::byte> bytes, const Progress& progress) {
  const std::optional<Head> head = head_of(bytes);
  if (!head) return {};
  const std::size_t pixel = head->pixel_bytes(), count = head->row_bytes();
  Texture texture;
  texture.format = {head->depth(), "png", nullptr};
  texture.pixels = Image<float>(head->width, head->height, head->channels);
  const std::size_t row_values = std::size_t(head->width) * head->channels;
  Inflater inflater(*head);
  TwoRows rows(pixel, count);
  for (int y = 0; y < head->height; ++y) {
    Byte filter;
    if (!inflater.take(&filter, 1) || !inflater.take(rows.row(), count) ||
        !unfilter(filter, pixel, count, rows.above(), rows.row()))
      return {};
    to_floats(rows.row(), head->value_bytes,
              texture.pixels.values().subspan(row_values * y, row_values));
    rows.next();
    if ((y + 1) % rows_per_report == 0 || y + 1 == head->height)
      progress.at(double(y + 1) / head->height);
  }
  if (!inflater.at_end()) return {};
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
  const std::size_t pixel = std::size_t(channels) * value_bytes, count = row_values * value_bytes;
  EncodedPicture encoded;
  ChunkWriter chunks(encoded.bytes);
  constexpr Byte kinds[4] = {0, 4, 2, 6};
  std::array<Byte, 13> head{};
  for (int i = 0; i < 4; ++i) {
    head[i] = Byte(pixels.width() >> (24 - 8 * i) & 255);
    head[4 + i] = Byte(pixels.height() >> (24 - 8 * i) & 255);
  }
  head[8] = Byte(8 * value_bytes), head[9] = kinds[channels - 1];
  chunks.add("IHDR", head);

  Deflater deflater(chunks);
  TwoRows rows(pixel, count);
  std::vector<std::byte> stored;
  std::array<std::vector<Byte>, 2> tried = {std::vector<Byte>(count + 1),
                                            std::vector<Byte>(count + 1)};
  std::int64_t clamped = 0;
  for (int y = 0; y < pixels.height(); ++y) {
    clamped += to_bytes(pixels.values().subspan(row_values * y, row_values), value_bytes, stored,
                        rows.row());
    choose_filter(pixel, count, rows, tried);
    deflater.add(tried[0]);
    rows.next();
    if ((y + 1) % rows_per_report == 0 || y + 1 == pixels.height())
      progress.at(double(y + 1) / pixels.height());
  }
  deflater.finish();
  chunks.add("IEND", {});
  encoded.notes = notes_on(name, texture, format, depth, clamped, false);
  return encoded;
}

}  // namespace mq
