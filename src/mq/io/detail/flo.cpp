#include "mq/io/detail/flo.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "mq/base/error.h"
#include "mq/io/image_file.h"

namespace mq {

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

namespace {

constexpr float magic = 202021.25F;
constexpr float unknown_from = 1e9F;  ///< this and what is larger is unknown: the benchmark's own
                                      ///< 10¹⁰, and what others write
constexpr float unknown_mark = 1e10F;

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw IoError(name + ": " + what);
}

}  // namespace

void mark_unknown_flow(Image<float>& field) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < field.values().size(); i += 2) {
    float &u = field.values()[i], &v = field.values()[i + 1];
    if (!(std::abs(u) < unknown_from) || !(std::abs(v) < unknown_from)) u = v = nan;
  }
}

Image<float> flow_from_bytes(std::span<const std::byte> bytes, const std::string& name) {
  constexpr std::size_t head = 12;
  float found = 0;
  std::int32_t size[2] = {0, 0};
  if (bytes.size() < head)
    fail(name,
         fmt::format("has {} bytes, and the head of a .flo alone has {}: cut short, or no flow",
                     bytes.size(), head));
  std::memcpy(&found, bytes.data(), 4);
  std::memcpy(size, bytes.data() + 4, 8);
  if (found != magic)
    fail(name,
         fmt::format("begins with {:g}, and a .flo with {}: it is something else", found, magic));
  if (size[0] < 1 || size[1] < 1 || size[0] > max_picture_side || size[1] > max_picture_side)
    fail(name, fmt::format("says it has {} x {} pixels; 1 to {} a side are read", size[0], size[1],
                           max_picture_side));
  const std::size_t wanted = head + 8 * std::size_t(size[0]) * std::size_t(size[1]);
  if (bytes.size() != wanted)
    fail(name, fmt::format("says it has {} x {} pixels, which is {} bytes, and has {}: {}", size[0],
                           size[1], wanted, bytes.size(),
                           bytes.size() < wanted ? "cut short; copy it again" : "damaged"));
  Image<float> field(size[0], size[1], 2);
  std::memcpy(field.values().data(), bytes.data() + head, wanted - head);
  mark_unknown_flow(field);
  return field;
}

Bytes bytes_of_flow(const Image<float>& field) {
  const std::int32_t size[2] = {field.width(), field.height()};
  const std::size_t head = sizeof magic + sizeof size;
  Bytes bytes(head + 4 * field.values().size());
  std::memcpy(bytes.data(), &magic, sizeof magic);
  std::memcpy(bytes.data() + sizeof magic, size, sizeof size);
  for (std::size_t i = 0; i < field.values().size(); ++i) {
    const float value = std::isfinite(field.values()[i]) ? field.values()[i] : unknown_mark;
    std::memcpy(bytes.data() + head + 4 * i, &value, 4);
  }
  return bytes;
}

}  // namespace mq
