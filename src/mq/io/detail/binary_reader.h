#pragma once
/// A cursor over a binary file that knows where the file ends.

#include <cstdint>
#include <string>

#include "mq/io/bytes.h"

namespace mq {

/// All functions throw `IoError` naming the file and the byte where it ends too early.
class BinaryReader {
 public:
  BinaryReader(std::string file, ByteView bytes) : file_(std::move(file)), bytes_(bytes) {}

  template <class Number>
  Number number() {
    need(sizeof(Number));
    Number value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }

  /// A 64-bit count of things that take `least` bytes each or more, so that there can be that many.
  std::uint64_t count(std::size_t least, const char* things);

  /// Text up to a zero byte, or of `size` bytes.
  std::string zero_text();
  std::string text(std::uint64_t size);

  void skip(std::uint64_t size) {
    need(size);
    at_ += std::size_t(size);
  }

  std::size_t left() const { return bytes_.size() - at_; }

  /// "FILE, byte 120".
  std::string place() const;

 private:
  void need(std::uint64_t size) const;

  std::string file_;
  ByteView bytes_;
  std::size_t at_ = 0;
};

}  // namespace mq
