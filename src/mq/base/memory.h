#pragma once
/// How much memory there is to work with.

#include <cstdint>
#include <string>

namespace mq {

/// Bytes that can still be had without killing anything: free memory and swap of the machine, or
/// what the control group leaves where that is less; of a program whose memory lies on a disk
/// (--memory) what that can take. Where the system does not tell (no /proc),
/// the largest number.
std::int64_t available_memory();

/// The most bytes of memory this program has occupied at a time, since it began: not those of the one that started it, which
/// getrusage counts in. 0 where the system does not tell.
std::int64_t peak_memory();

/// Throws `OutOfMemory` when `bytes` are more than `available_memory()`, naming both: "<what> needs
/// about 12.3 GB of memory and 8.1 GB are free: <remedy>". Systems that promise more memory than
/// they have kill the program later instead.
void require_memory(std::int64_t bytes, const std::string& what, const std::string& remedy);

}  // namespace mq
