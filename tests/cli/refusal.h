#pragma once
/// Calls that the program must refuse.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/program.h"

namespace mq::test {

/// What it says on refusing these words; a failure unless it ends with status 2 and leaves no file
/// `output`.
inline std::string refusal(const Folder& folder, const std::vector<std::string>& words,
                           const std::string& output) {
  const Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 2) << result.output << result.error;
  EXPECT_FALSE(std::filesystem::exists(folder / output));
  return result.error;
}

}  // namespace mq::test
