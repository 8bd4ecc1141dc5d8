#include "mq/io/detail/binary_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"

namespace mq {

std::string BinaryReader::place() const { return fmt::format("{}, byte {}", file_, at_); }

void BinaryReader::need(std::uint64_t size) const {
  if (size > left())
    throw IoError(fmt::format("{}: wanted {} more bytes, and the file ends after {}: check that it was "
                              "copied whole",
                              place(), size, left()));
}

std::uint64_t BinaryReader::count(std::size_t least, const char* things) {
  const std::string where = place();
  const auto found = number<std::uint64_t>();
  if (found > left() / least)
    throw IoError(fmt::format("{}: found a count of {} {}, more than the {} bytes that follow can hold: "
                              "check that it was copied whole",
                              where, found, things, left()));
  return found;
}

std::string BinaryReader::zero_text() {
  const auto rest = bytes_.subspan(at_);
  const auto end = std::ranges::find(rest, std::byte{0});
  if (end == rest.end())
    throw IoError(place() + ": wanted a name that ends in a zero byte, and the file ends before: check "
                            "that it was copied whole");
  const std::string found = text(std::uint64_t(end - rest.begin()));
  ++at_;
  return found;
}

std::string BinaryReader::text(std::uint64_t size) {
  need(size);
  const std::string found(text_of(bytes_.subspan(at_, std::size_t(size))));
  at_ += std::size_t(size);
  return found;
}

}  // namespace mq
