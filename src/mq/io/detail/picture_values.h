#pragma once
/// Values on their way into a picture file, whatever writes it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "mq/io/detail/picture_formats.h"

namespace mq {

/// Throws `InvalidInput` where the format cannot hold the picture, `IoError` where it is not finite.
void check_writable(const Texture& texture, const std::string& name, const FileFormat& format);

/// Throws `IoError` with the place of the first of the values begin … end − 1 that is not finite.
void check_finite(const std::string& name, const Image<float>& pixels, std::size_t begin,
                  std::size_t end, const char* remedy);

/// Rounds to the nearest stored value. Returns how many lay outside by more than that rounding.
template <class Stored>
std::int64_t quantise(std::span<const float> from, std::vector<std::byte>& to) {
  constexpr float largest = float(std::numeric_limits<Stored>::max());
  to.resize(from.size() * sizeof(Stored));
  auto* stored = reinterpret_cast<Stored*>(to.data());
  std::int64_t clamped = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const float scaled = from[i] * largest;
    clamped += scaled < -0.5f || scaled > largest + 0.5f;
    stored[i] = Stored(std::clamp(scaled, 0.0f, largest) + 0.5f);
  }
  return clamped;
}

/// What is said about a picture that was written with `depth`; `light`: its values are light.
std::vector<std::string> notes_on(const std::string& name, const Texture& texture,
                                  const FileFormat& format, Depth depth, std::int64_t clamped,
                                  bool light);

}  // namespace mq
