#pragma once
/// Where TIFF and OpenEXR with several parts are written to. OpenImageIO's own writer into memory does not let
/// libtiff go back to what it wrote, as it does when there are EXIF tags, and is passed over by OpenEXR with
/// several parts.

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "mq/base/error.h"

namespace mq {

/// Memory that has the name of a file.
class MemoryFile {
 public:
  MemoryFile() : file_(::memfd_create("picture", MFD_CLOEXEC)) {
    if (file_ < 0) throw IoError(fmt::format("no memory to write to: {}", std::strerror(errno)));
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string name() const { return fmt::format("/proc/self/fd/{}", file_); }

  std::vector<std::byte> bytes() const {
    std::vector<std::byte> all(std::size_t(std::max<off_t>(0, ::lseek(file_, 0, SEEK_END))));
    for (std::size_t done = 0; done < all.size();) {
      const ssize_t got = ::pread(file_, all.data() + done, all.size() - done, off_t(done));
      if (got <= 0) throw IoError("what was encoded cannot be read back");
      done += std::size_t(got);
    }
    return all;
  }

 private:
  int file_;
};

}  // namespace mq
