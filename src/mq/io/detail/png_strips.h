#pragma once
/// Rows of a picture as the compressed data of a PNG, in strips that threads filter and compress side by side.
///
/// One zlib stream (RFC 1950, 1951) as every reader expects: strips end at whole bytes by an empty stored block, and each
/// begins with what came before it as its dictionary, so that next to nothing is lost to the cuts. Where they are depends
/// on the size of the picture alone. Filters: PNG (ISO/IEC 15948) 9, for each row the one whose differences have the
/// least sum of absolute values (12.8).

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace mq {

class PngStrips {
 public:
  /// Writes the bytes of a row as the file has them, before filters.
  using RowOf = std::function<void(int row, std::uint8_t* to)>;

  /// `pixel_bytes`: from a value to that of the pixel beside it. `level`, `strategy`: zlib's.
  PngStrips(int height, std::size_t row_bytes, int pixel_bytes, int level, int strategy);

  int count() const { return (height_ + rows_ - 1) / rows_; }
  int begin(int strip) const { return strip * rows_; }
  int end(int strip) const { return begin(strip) + rows_ < height_ ? begin(strip) + rows_ : height_; }

  /// A strip's part of the stream, and the check sum (Adler-32) of the `size` bytes it stands for.
  struct Strip {
    std::vector<std::uint8_t> bytes;
    std::uint32_t sum = 1;
    std::size_t size = 0;
  };

  /// Asks for the rows of the strip and for those before it that its dictionary has. Any strips at the same time.
  /// Throws `IoError` where there is no memory.
  Strip compress(int strip, const RowOf& row) const;

  /// The check sum of `before`, followed by a strip of this sum and size.
  static std::uint32_t sum(std::uint32_t before, const Strip& strip);

 private:
  std::vector<std::uint8_t> filtered(int first, int end, const RowOf& row) const;

  int height_, rows_;
  std::size_t row_bytes_;
  int pixel_bytes_, level_, strategy_;
};

}  // namespace mq
