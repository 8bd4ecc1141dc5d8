#pragma once
/// Whether values are those that were read, without reading them again.

#include <cstddef>
#include <cstdint>
#include <span>

#include "mq/io/file_print.h"
#include "mq/io/model.h"

namespace mq {

/// Of a texture's pixels, size and depth.
std::uint64_t fingerprint(const Texture& texture);

/// Whether a texture still has the pixels and the depth with which it was read.
bool keeps_pixels(const Texture& texture);

/// Whether, besides, these are the bytes it was read from.
bool is_as_read(const Texture& texture, std::span<const std::byte> bytes);

}  // namespace mq
