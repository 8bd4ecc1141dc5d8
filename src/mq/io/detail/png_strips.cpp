#include "mq/io/detail/png_strips.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "mq/base/error.h"

namespace mq {
namespace {

using Byte = std::uint8_t;

constexpr std::size_t strip_bytes = std::size_t(1) << 18;
constexpr std::size_t dictionary_bytes = std::size_t(1) << 15;  // as far as deflate looks back
constexpr int memory_level = 8;                                 // as libpng has it
constexpr std::array<Byte, 2> head = {0x78, 0x5E};              // a window of 32 KiB, compressed fast

/// Of the values to the left, above, and above that to the left the one nearest to left + above − corner; in this order
/// where two are as near.
Byte paeth(int left, int above, int corner) {
  const int to_left = std::abs(above - corner), to_above = std::abs(left - corner),
            to_corner = std::abs(left + above - 2 * corner);
  const int nearer = to_above <= to_corner ? above : corner;
  return Byte(to_left <= to_above && to_left <= to_corner ? left : nearer);
}

/// Calls predict(left, above, corner) for all bytes of a row and keeps the differences. Bytes before both rows are 0.
template <class Predict>
int filter(const Byte* row, const Byte* above, std::size_t count, int pixel, Byte* to, const Predict& predict) {
  for (std::size_t i = 0; i < count; ++i)
    to[i] = Byte(row[i] - predict(row[std::ptrdiff_t(i) - pixel], above[i], above[std::ptrdiff_t(i) - pixel]));
  int sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += std::abs(int(static_cast<signed char>(to[i])));
  return sum;
}

/// The row behind the number of its filter, 0 to 4.
class RowFilter {
 public:
  RowFilter(std::size_t row_bytes, int pixel_bytes) : pixel_(pixel_bytes), best_(row_bytes), other_(row_bytes) {}

  void append(const Byte* row, const Byte* above, std::vector<Byte>& to) {
    const std::size_t n = best_.size();
    int least = filter(row, above, n, pixel_, best_.data(), [](int, int, int) { return 0; }), kind = 0;
    const auto try_filter = [&](int number, const auto& predict) {
      const int sum = filter(row, above, n, pixel_, other_.data(), predict);
      if (sum >= least) return;
      least = sum;
      kind = number;
      best_.swap(other_);
    };
    try_filter(1, [](int left, int, int) { return left; });
    try_filter(2, [](int, int up, int) { return up; });
    try_filter(3, [](int left, int up, int) { return (left + up) / 2; });
    try_filter(4, [](int left, int up, int corner) { return int(paeth(left, up, corner)); });
    to.push_back(Byte(kind));
    to.insert(to.end(), best_.begin(), best_.end());
  }

 private:
  int pixel_;
  std::vector<Byte> best_, other_;
};

/// A stream of deflate without zlib's head and sum.
class Deflater {
 public:
  Deflater(int level, int strategy) {
    constexpr int window_bits = 15;
    if (deflateInit2(&stream_, level, Z_DEFLATED, -window_bits, memory_level, strategy) != Z_OK)
      throw IoError("no memory to write a picture");
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void look_back_to(const Byte* bytes, std::size_t count) {
    if (count > 0) deflateSetDictionary(&stream_, bytes, uInt(count));
  }

  /// `flush`: Z_SYNC_FLUSH, which ends at a whole byte, or Z_FINISH.
  void append(const Byte* bytes, std::size_t count, int flush, std::vector<Byte>& to) {
    constexpr std::size_t flush_bytes = 16;
    const std::size_t before = to.size();
    to.resize(before + deflateBound(&stream_, uLong(count)) + flush_bytes);
    stream_.next_in = const_cast<Byte*>(bytes);
    stream_.avail_in = uInt(count);
    stream_.next_out = to.data() + before;
    stream_.avail_out = uInt(to.size() - before);
    const int result = deflate(&stream_, flush);
    if (stream_.avail_in > 0 || result != (flush == Z_FINISH ? Z_STREAM_END : Z_OK))
      throw IoError("a picture could not be compressed");
    to.resize(to.size() - stream_.avail_out);
  }

 private:
  z_stream stream_{};
};

}  // namespace

PngStrips::PngStrips(int height, std::size_t row_bytes, int pixel_bytes, int level, int strategy)
    : height_(height),
      rows_(int(std::clamp<std::size_t>(strip_bytes / (row_bytes + 1), 1, std::size_t(std::max(height, 1))))),
      row_bytes_(row_bytes),
      pixel_bytes_(pixel_bytes),
      level_(level),
      strategy_(strategy) {}

std::vector<Byte> PngStrips::filtered(int first, int end, const RowOf& row) const {
  std::vector<Byte> result;
  result.reserve((row_bytes_ + 1) * std::size_t(end - first));
  std::vector<Byte> here(row_bytes_ + std::size_t(pixel_bytes_), 0), above = here;
  if (first > 0) row(first - 1, above.data() + pixel_bytes_);
  RowFilter filter(row_bytes_, pixel_bytes_);
  for (int y = first; y < end; ++y) {
    row(y, here.data() + pixel_bytes_);
    filter.append(here.data() + pixel_bytes_, above.data() + pixel_bytes_, result);
    here.swap(above);
  }
  return result;
}

PngStrips::Strip PngStrips::compress(int strip, const RowOf& row) const {
  const int first = begin(strip);
  const int rows_before = std::min(first, int(dictionary_bytes / (row_bytes_ + 1)) + 1);
  const std::vector<Byte> bytes = filtered(first - rows_before, end(strip), row);
  const std::size_t before = (row_bytes_ + 1) * std::size_t(rows_before),
                    dictionary = std::min(before, dictionary_bytes);
  Strip result;
  if (strip == 0) result.bytes.assign(head.begin(), head.end());
  Deflater deflater(level_, strategy_);
  deflater.look_back_to(bytes.data() + before - dictionary, dictionary);
  result.size = bytes.size() - before;
  deflater.append(bytes.data() + before, result.size, strip + 1 == count() ? Z_FINISH : Z_SYNC_FLUSH, result.bytes);
  result.sum = std::uint32_t(adler32(1, bytes.data() + before, uInt(result.size)));
  return result;
}

std::uint32_t PngStrips::sum(std::uint32_t before, const Strip& strip) {
  return std::uint32_t(adler32_combine(before, strip.sum, z_off_t(strip.size)));
}

}  // namespace mq
