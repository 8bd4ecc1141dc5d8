#pragma once
/// Whole numbers in streams, each stream coded by the packaged coder that makes it smallest.
///
/// A number below 16 is a token of its own; of a larger one the token says how many bits it has and the bit after
/// the highest, and the bits below that follow as they are. Tokens of a stream are one value repeated, or coded by
/// rANS (Draco), or by deflate, and in early stores by zstd; which one is a byte. Numbers that are alike belong in one stream, those that are told
/// apart by what both sides know already in streams of their own.

#include <cstdint>
#include <string>
#include <vector>

#include "mq/io/bytes.h"

namespace mq {

/// 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
inline std::uint64_t folded(std::int64_t value) { return (std::uint64_t(value) << 1) ^ std::uint64_t(value >> 63); }
inline std::int64_t unfolded(std::uint64_t value) { return std::int64_t(value >> 1) ^ -std::int64_t(value & 1); }

class SymbolWriter {
 public:
  explicit SymbolWriter(int streams) : tokens_(std::size_t(streams)) {}

  void put(int stream, std::uint64_t value);
  void put_signed(int stream, std::int64_t value) { put(stream, folded(value)); }

  /// All streams and the bits.
  Bytes bytes() const;

 private:
  std::vector<std::vector<std::uint32_t>> tokens_;
  Bytes bits_;
  int free_bits_ = 0;  ///< of the last byte, the highest ones
};

class SymbolReader {
 public:
  /// At most `most` numbers in all, which bounds memory. Throws `IoError` beginning with `what` where bytes are no such
  /// streams; bytes after them have to be 0.
  SymbolReader(ByteView bytes, int streams, std::size_t most, std::string what);

  /// The next number of a stream. Throws where there is none.
  std::uint64_t get(int stream) {
    Stream& from = streams_[std::size_t(stream)];
    if (from.at == from.tokens.size()) fail("ends too early");
    const std::uint32_t token = from.tokens[from.at++];
    return token < 16 ? token : long_number(token);
  }
  std::int64_t get_signed(int stream) { return unfolded(get(stream)); }

  /// A number below `end`. Throws where it is not.
  std::size_t index(int stream, std::size_t end);

  /// Throws where a stream has numbers left.
  void end() const;

  [[noreturn]] void fail(const std::string& found) const;

 private:
  struct Stream {
    std::vector<std::uint32_t> tokens;
    std::size_t at = 0;
  };
  std::uint64_t leb(ByteView bytes, std::size_t& at) const;
  void decode(ByteView payload, int method, Stream& stream) const;
  std::uint64_t long_number(std::uint32_t token);

  std::vector<Stream> streams_;
  Bytes bits_;
  std::size_t bit_ = 0;
  std::string what_;
};

}  // namespace mq
