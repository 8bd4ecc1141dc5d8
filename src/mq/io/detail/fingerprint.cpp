#include "mq/io/detail/fingerprint.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Odd numbers without pattern: multiplying by them spreads each bit over all higher ones.
constexpr std::uint64_t first_factor = 0x9E3779B97F4A7C15, second_factor = 0xC2B2AE3D27D4EB4F;

std::uint64_t mixed_with(std::uint64_t hash, std::uint64_t word) {
  return std::rotl(hash ^ (word * first_factor), 29) * second_factor;
}

std::uint64_t of_block(std::span<const std::byte> bytes) {
  std::uint64_t hash = bytes.size();
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t count = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), count);
    hash = mixed_with(hash, word);
    bytes = bytes.subspan(count);
  }
  return hash ^ (hash >> 32);
}

}  // namespace

std::uint64_t fingerprint(std::span<const std::byte> bytes) {
  constexpr std::size_t block = std::size_t(1) << 20;
  std::vector<std::uint64_t> parts((bytes.size() + block - 1) / block);
  parallel_for(
      std::ssize(parts),
      [&](std::int64_t k) {
        const std::size_t first = std::size_t(k) * block;
        parts[std::size_t(k)] = of_block(bytes.subspan(first, std::min(block, bytes.size() - first)));
      },
      1);
  std::uint64_t hash = bytes.size();
  for (const std::uint64_t part : parts) hash = mixed_with(hash, part);
  return std::max<std::uint64_t>(hash, 1);
}

std::uint64_t fingerprint(const Texture& texture) {
  const Image<float>& pixels = texture.pixels;
  std::uint64_t hash = fingerprint(std::as_bytes(pixels.values()));
  for (const int number : {pixels.width(), pixels.height(), pixels.channels(), int(texture.format.depth)})
    hash = mixed_with(hash, std::uint64_t(number));
  return std::max<std::uint64_t>(hash, 1);
}

bool keeps_pixels(const Texture& texture) {
  return texture.as_read.pixels != 0 && fingerprint(texture) == texture.as_read.pixels;
}

bool is_as_read(const Texture& texture, std::span<const std::byte> bytes) {
  return keeps_pixels(texture) && fingerprint(bytes) == texture.as_read.bytes;
}

}  // namespace mq
