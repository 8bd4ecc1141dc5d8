#pragma once
/// An archive of files as they are, as USD wants its packages: not compressed, the bytes of each file at a
/// multiple of 64 (Pixar, Usdz File Format Specification 1.3). The container is PKWARE's, APPNOTE 6.3.3.

#include <vector>

#include "mq/io/document.h"

namespace mq {

/// Files in this order, with dates of 1980. Throws `Unsupported` where all is more than 4 GB.
Bytes stored_zip(const std::vector<OutputFile>& files);

}  // namespace mq
