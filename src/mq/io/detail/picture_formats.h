#pragma once
/// The formats in which pictures are written, and what each of them can hold.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mq/io/model.h"

namespace mq {

struct FileFormat {
  std::string_view name;  ///< as OpenImageIO calls it
  std::vector<std::string_view> extensions;
  int max_channels;
  std::array<Depth, 4> depth;  ///< how it stores a u8, u16, half, f32
};

/// By OpenImageIO's name. Throws `InvalidInput` where there is no such one.
const FileFormat& format_named(const std::string& name);

/// The format that an extension names; null where it names none.
const FileFormat* format_of_extension(const std::filesystem::path& path);

}  // namespace mq
