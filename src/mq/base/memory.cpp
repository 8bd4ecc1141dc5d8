#include "mq/base/memory.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The one number in a file; -1 where there is no such file or it says "max".
std::int64_t number_in(const char* path) {
  std::int64_t number = -1;
  std::ifstream file(path);
  return file >> number ? number : -1;
}

/// What a named line of a file says, -1 where there is none.
std::int64_t entry_of(const char* path, const std::string& wanted) {
  std::ifstream file(path);
  std::int64_t number = 0;
  for (std::string name; file >> name >> number;)
    if (name == wanted) return number;
  return -1;
}

std::int64_t free_on_machine() {
  std::ifstream file("/proc/meminfo");
  std::int64_t sum = 0, kilobytes = 0;
  bool found = false;
  for (std::string name, rest; file >> name >> kilobytes; std::getline(file, rest))
    if (name == "MemAvailable:" || name == "SwapFree:") {
      sum += 1024 * kilobytes;
      found = true;
    }
  return found ? sum : std::numeric_limits<std::int64_t>::max();
}

/// What the file of a program that has its memory on the disk can still take (apps/scratch); 0 in others.
std::int64_t scratch_left() {
  using Left = std::int64_t (*)();
  static const auto left = reinterpret_cast<Left>(::dlsym(RTLD_DEFAULT, "marquetry_scratch_left"));
  return left == nullptr ? 0 : left();
}

}  // namespace

std::int64_t available_memory() {
  if (const std::int64_t disk = scratch_left(); disk > 0) return disk;
  const std::int64_t limit = number_in("/sys/fs/cgroup/memory.max"),
                     used = number_in("/sys/fs/cgroup/memory.current");
  const std::int64_t machine = free_on_machine();
  if (limit < 0 || used < 0) return machine;
  // Pages of files that nobody maps are given up at need.
  const std::int64_t pages = entry_of("/sys/fs/cgroup/memory.stat", "inactive_file");
  return std::clamp<std::int64_t>(limit - used + std::max<std::int64_t>(pages, 0), 0, machine);
}

std::int64_t peak_memory() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::stoll(line.substr(6));
  return 0;
}

void require_memory(std::int64_t bytes, const std::string& what, const std::string& remedy) {
  const std::int64_t available = available_memory();
  if (bytes <= available) return;
  throw OutOfMemory(fmt::format("{} needs about {:.1f} GB of memory and {:.1f} GB{} are free: {}", what,
                                1e-9 * double(bytes), 1e-9 * double(available),
                                scratch_left() > 0 ? " of the disk" : "", remedy));
}

}  // namespace mq
