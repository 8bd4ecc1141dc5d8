#pragma once
/// What the rules read: the project's own files.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "places.h"

namespace mq::rules {

/// The folder of the project.
inline const std::filesystem::path root = places::source();

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace mq::rules
