#pragma once
/// An archive of files as they are, as USD wants its packages: not compressed, the bytes of each file at a
/// multiple of 64 (Pixar, Usdz File Format Specification 1.3). The container is PKWARE's, APPNOTE 6.3.3.

#include <string>
#include <vector>

#include "mq/io/document.h"

namespace mq {

/// Files in this order, with dates of 1980. Throws `Unsupported` where all is more than 4 GB.
Bytes stored_zip(const std::vector<OutputFile>& files);

/// A file in an archive.
struct StoredFile {
  std::string name;
  ByteView bytes;  ///< of the archive
};

/// The files of such an archive, in its order, their checksums compared. Throws `IoError`, which begins with
/// `name`, where it is cut short or changed, or a file in it is compressed.
std::vector<StoredFile> stored_files(ByteView zip, const std::string& name);

}  // namespace mq
