#pragma once
/// Pictures in a folder of a test's own.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "mq/base/error.h"
#include "mq/io/image_file.h"

namespace mq::test {

class ImageFile : public ::testing::Test {
 protected:
  ImageFile() { std::filesystem::create_directories(folder); }
  ~ImageFile() override { std::filesystem::remove_all(folder); }

  std::filesystem::path put(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  static std::string get(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("mq image file " + std::to_string(::getpid()) +
                                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

inline std::string error_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Every value is one that `largest` levels can hold, and all of them differ.
inline Image<float> levels(int width, int height, int channels, int largest) {
  Image<float> image(width, height, channels);
  std::uint32_t state = 1;
  for (float& v : image.values()) {
    state = state * 1664525u + 1013904223u;
    v = float((state >> 8) % (unsigned(largest) + 1)) / float(largest);
  }
  return image;
}

}  // namespace mq::test
