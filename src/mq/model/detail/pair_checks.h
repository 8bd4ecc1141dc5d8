#pragma once
/// What pairs of signals are checked for.

#include <fmt/format.h>

#include <string>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/model.h"

namespace mq {

/// A range below this share of the largest value is rounding.
inline constexpr double least_range = 1e-6;

/// "40 x 30 pixels with 3 channels"
inline std::string size_in_words(const Texture& texture) {
  return fmt::format("{} x {} pixels with {}", texture.pixels.width(), texture.pixels.height(),
                     counted(texture.pixels.channels(), "channel"));
}

/// Throws `InvalidInput` where the picture of this name is not like the other.
inline void require_alike(const Texture& texture, const std::string& name, const Texture& other,
                          const std::string& other_name) {
  require(texture.pixels.width() == other.pixels.width() &&
              texture.pixels.height() == other.pixels.height() &&
              texture.pixels.channels() == other.pixels.channels(),
          fmt::format("{}: has {}, and {} has {}: convert one of them", name,
                      size_in_words(texture), other_name, size_in_words(other)));
}

}  // namespace mq
