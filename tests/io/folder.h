#pragma once
/// A folder of a test's own, and files in it.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "mq/base/error.h"

namespace mq {

/// An empty folder, removed with what is in it.
class FolderTest : public ::testing::Test {
 protected:
  FolderTest() { std::filesystem::create_directories(folder); }
  ~FolderTest() override { std::filesystem::remove_all(folder); }

  std::filesystem::path put(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  std::string get(const std::string& name) const {
    std::ifstream in(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  bool there(const std::string& name) const { return std::filesystem::exists(folder / name); }
  int files() const {
    return int(std::distance(std::filesystem::recursive_directory_iterator(folder),
                             std::filesystem::recursive_directory_iterator()));
  }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() /
      ("mq_" + std::to_string(::getpid()) + "_" +
       ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

/// What the action throws as `IoError`; empty when it does not.
std::string io_error_of(const auto& action) {
  try {
    action();
  } catch (const IoError& error) {
    return error.what();
  }
  return "";
}

}  // namespace mq
