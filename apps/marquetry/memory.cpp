#include "memory.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

namespace mq::app {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number of kilobytes beside `name` in a file such as /proc/meminfo, as bytes.
double bytes_beside(const char* file, const std::string& name, double otherwise) {
  std::ifstream in(file);
  for (std::string word; in >> word;)
    if (double kilobytes = 0; word == name && in >> kilobytes) return kilobytes * 1024;
  return otherwise;
}

/// What is left of the address space that `ulimit -v` allows.
double address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  return std::max(0.0, double(limit.rlim_cur) - bytes_beside("/proc/self/status", "VmSize:", 0));
}

/// What is left of the memory that a container allows (cgroup version 2).
double container_memory() {
  double most = 0, used = 0;
  if (!(std::ifstream("/sys/fs/cgroup/memory.max") >> most)) return unlimited;  // "max", or no file
  std::ifstream("/sys/fs/cgroup/memory.current") >> used;
  return std::max(0.0, most - used);
}

}  // namespace

double factorisation_bytes(std::int64_t unknowns) {
  // Measured: docs/performance.md, "Memory of a factorisation".
  constexpr double bytes_per_unknown_and_doubling = 80;
  const double n = double(std::max<std::int64_t>(2, unknowns));
  return bytes_per_unknown_and_doubling * n * std::log2(n);
}

double free_bytes() {
  const double there = bytes_beside("/proc/meminfo", "MemAvailable:", unlimited);
  return std::min({there, address_space(), container_memory()});
}

}  // namespace mq::app
