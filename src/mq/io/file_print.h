#pragma once
/// What tells whether a file is as it was.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// The files that a model was read from: its own, then its material libraries or buffers, then the
/// pictures that were read. None of a model made in memory.
std::vector<std::filesystem::path> files_of(const Model& model);

/// A file's length and the CRC-32 (IEEE 802.3) of its bytes.
struct FilePrint {
  std::int64_t bytes = 0;
  std::uint32_t crc32 = 0;

  bool operator==(const FilePrint&) const = default;
};

/// Of the file as it is now. Throws `IoError` where it cannot be read.
FilePrint file_print(const std::filesystem::path& path);

}  // namespace mq
