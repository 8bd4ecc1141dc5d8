#pragma once
/// What the bytes of a TIFF say before they are decoded [TIFF 6.0, section 2; BigTIFF].

#include <cstdint>
#include <optional>
#include <vector>

#include "mq/io/bytes.h"

namespace mq {

/// Numbers in a TIFF, of either byte order.
class TiffBytes {
 public:
  explicit TiffBytes(ByteView bytes)
      : bytes_(bytes), big_endian_(bytes.size() > 1 && bytes[0] == std::byte('M') && bytes[1] == std::byte('M')) {}

  std::uint64_t size() const { return bytes_.size(); }
  bool is_big_endian() const { return big_endian_; }

  /// The unsigned integer of `width` bytes at a place; nothing where the file ends before.
  std::optional<std::uint64_t> number(std::uint64_t at, unsigned width) const {
    if (at > bytes_.size() || bytes_.size() - at < width) return {};
    std::uint64_t value = 0;
    for (unsigned i = 0; i < width; ++i) {
      const std::uint64_t byte = std::to_integer<std::uint64_t>(bytes_[at + i]);
      value |= byte << 8 * (big_endian_ ? width - 1 - i : i);
    }
    return value;
  }

 private:
  ByteView bytes_;
  bool big_endian_;
};

/// An entry of a directory: what `tag` says, as `count` values of a type.
struct TiffEntry {
  std::uint64_t place = 0;  ///< of the entry
  unsigned tag = 0, type = 0;
  std::uint64_t count = 0;
  std::uint64_t values = 0;  ///< where they are, if they take `width` bytes each
  unsigned width = 0;        ///< of a value; 0: a type that is not known
};

/// The entries of the first directory; nothing where it does not lie in the file.
inline std::optional<std::vector<TiffEntry>> first_directory(const TiffBytes& tiff) {
  const bool large = tiff.number(2, 2) == 43;  // BigTIFF
  const unsigned word = large ? 8 : 4, entry_size = large ? 20 : 12;
  const auto directory = tiff.number(large ? 8 : 4, word);
  const auto count = directory ? tiff.number(*directory, large ? 8 : 2) : directory;
  if (!count || *count > tiff.size() / entry_size) return {};
  constexpr unsigned widths[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  std::vector<TiffEntry> entries;
  for (std::uint64_t i = 0; i < *count; ++i) {
    TiffEntry entry{.place = *directory + (large ? 8 : 2) + i * entry_size};
    const auto tag = tiff.number(entry.place, 2), type = tiff.number(entry.place + 2, 2),
               values = tiff.number(entry.place + 4, word), inside = tiff.number(entry.place + 4 + word, word);
    if (!tag || !type || !values || !inside) return {};
    entry.tag = unsigned(*tag), entry.type = unsigned(*type), entry.count = *values;
    entry.width = *type < std::size(widths) ? widths[*type] : 0;
    const bool fits = entry.width > 0 && entry.count <= word / entry.width;
    entry.values = fits ? entry.place + 4 + word : *inside;
    entries.push_back(entry);
  }
  return entries;
}

}  // namespace mq
