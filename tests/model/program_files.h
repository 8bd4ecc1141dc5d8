#pragma once
/// What the program writes, to compare with what the library's calls write.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/models.h"
#include "mq/model/textured_model.h"

namespace mq {

/// Runs the program in the folder, which it must not refuse.
inline void run(const test::Folder& folder, const std::vector<std::string>& words) {
  const test::Result result = test::marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
}

inline std::string bytes(const test::Folder& folder, const std::string& file) {
  return test::file_bytes(folder / file);
}

/// The strip of two charts, as a file and as a model.
struct TwoCharts {
  test::Folder folder;
  Messages messages;
  TexturedModel model;

  explicit TwoCharts(MissingPictures missing = MissingPictures::refuse) {
    test::write_strip(folder);
    model = load_textured_model(folder / "strip.obj", {.missing = missing}, messages);
  }
};

}  // namespace mq
