#pragma once
/// What tells whether a file, or bytes, are as they were.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// The files that a model was read from: its own, then its material libraries or buffers, then the
/// pictures that were read. None of a model made in memory.
std::vector<std::filesystem::path> files_of(const Model& model);

/// 64 bits of these bytes, the same for any number of threads; never 0. For telling whether something
/// was changed, not for keeping anybody out.
std::uint64_t fingerprint(std::span<const std::byte> bytes);

/// A file's length and the CRC-32 (IEEE 802.3) of its bytes.
struct FilePrint {
  std::int64_t bytes = 0;
  std::uint32_t crc32 = 0;

  bool operator==(const FilePrint&) const = default;
};

/// Of the file as it is now. Throws `IoError` where it cannot be read.
FilePrint file_print(const std::filesystem::path& path);

}  // namespace mq
