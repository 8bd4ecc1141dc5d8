#pragma once
/// A picture in a quarter or half of its memory while nobody looks at it.

#include <cstdint>
#include <variant>

#include "mq/base/overwritten.h"
#include "mq/image/image.h"

namespace mq {

/// As bytes where every value is k/255, as words where every one is k/65535, which is what pictures of 8 and 16 bits are
/// read as; else as it is.
class PackedImage {
 public:
  explicit PackedImage(Image<float>&& image);

  /// The same picture, bit for bit.
  Image<float> unpacked() &&;

  /// Of what it keeps.
  std::int64_t bytes() const;

 private:
  int width_, height_, channels_;
  std::variant<Image<float>, OverwrittenVector<std::uint8_t>, OverwrittenVector<std::uint16_t>> values_;
};

}  // namespace mq
