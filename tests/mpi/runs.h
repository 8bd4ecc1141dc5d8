#pragma once
/// Verbs run by several processes, and what they leave.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/program.h"
#include "mq/io/model.h"
#include "places.h"

namespace mq::test {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

inline Result mpirun(const Folder& folder, int processes, const Words& words, RunOptions options = {}) {
  Words all{MQ_MPIRUN, "--oversubscribe", "--allow-run-as-root", "-n", std::to_string(processes),
            (places::program().parent_path() / "marquetry-mpi").string()};
  all.insert(all.end(), words.begin(), words.end());
  options.program = "/usr/bin/env";
  return marquetry(folder, all, options);
}

inline void make(const Folder& folder, Words words) {
  words.insert(words.begin(), "sample");
  const Result made = marquetry(folder, words);
  ASSERT_EQ(made.status, 0) << made.error;
}

/// The largest difference of two pictures.
inline double difference(const fs::path& a, const fs::path& b) {
  const Texture first = read_texture(a), second = read_texture(b);
  EXPECT_EQ(first.pixels.values().size(), second.pixels.values().size());
  double largest = 0;
  for (std::size_t i = 0; i < first.pixels.values().size(); ++i)
    largest = std::max(largest, double(std::abs(first.pixels.values()[i] - second.pixels.values()[i])));
  return largest;
}

}  // namespace mq::test
