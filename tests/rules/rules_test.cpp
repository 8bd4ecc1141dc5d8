// The rules of the house that a compiler does not check, read from the sources.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "places.h"

namespace {

namespace fs = std::filesystem;

const fs::path root = mq::places::source();

/// In the order data flows: a room includes itself and the rooms before it.
const std::vector<std::string> rooms = {
    "base",   "linear", "image", "mesh",  "remesh", "unwrap", "atlas", "fem",   "evolving", "trace",
    "filter", "flow",   "track", "video", "draw",   "sample", "io",    "model", "baseline"};

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// C++ files below a folder of the project.
std::vector<fs::path> sources(const std::string& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(root / folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".h" || extension == ".cpp") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

std::string place(const fs::path& path, std::size_t line) {
  return fs::relative(path, root).string() + ":" + std::to_string(line + 1);
}

/// What the files below `folder` include, in quotes or angles, with where they do.
struct Include {
  fs::path file;
  std::string name;
  std::string where;
};

std::vector<Include> includes(const std::string& folder) {
  static const std::regex pattern(R"(^\s*#\s*include\s*["<]([^">]+)[">])");
  std::vector<Include> all;
  for (const fs::path& file : sources(folder)) {
    const auto lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      std::smatch match;
      if (std::regex_search(lines[i], match, pattern))
        all.push_back({file, match[1], place(file, i)});
    }
  }
  return all;
}

std::ptrdiff_t rank(const std::string& room) {
  const auto found = std::ranges::find(rooms, room);
  return found == rooms.end() ? -1 : found - rooms.begin();
}

/// The room a file lies in, or that an include names.
std::string room_of(const fs::path& file) {
  return (*fs::relative(file, root / "src/mq").begin()).string();
}

std::string room_of_include(const std::string& name) {
  if (!name.starts_with("mq/")) return "";
  return name.substr(3, name.find('/', 3) - 3);
}

TEST(Rooms, AreTheOnesTheHouseKnows) {
  for (const auto& entry : fs::directory_iterator(root / "src/mq"))
    if (entry.is_directory()) {
      EXPECT_GE(rank(entry.path().filename().string()), 0) << entry.path();
    }
}

TEST(Rooms, IncludeOnlyRoomsAboveThem) {
  const auto all = includes("src/mq");
  ASSERT_GT(all.size(), 20U);
  for (const Include& include : all) {
    const std::string to = room_of_include(include.name);
    if (to.empty()) continue;
    EXPECT_GE(rank(to), 0) << include.where << " includes an unknown room: " << include.name;
    EXPECT_LE(rank(to), rank(room_of(include.file)))
        << include.where << " includes upward: " << include.name;
  }
}

TEST(Rooms, IncludeNothingThatExistsOnlyToBeComparedWith) {
  for (const Include& include : includes("src/mq"))
    if (room_of(include.file) != "baseline") {
      EXPECT_NE(room_of_include(include.name), "baseline") << include.where;
    }
}

TEST(Rooms, KeepDetailsToThemselves) {
  for (const char* folder : {"src", "apps"})
    for (const Include& include : includes(folder))
      if (include.name.starts_with("mq/") && include.name.find("/detail/") != std::string::npos) {
        EXPECT_EQ(room_of_include(include.name), room_of(include.file)) << include.where;
      }
}

TEST(Rooms, KeepFileFormatsInIo) {
  static const std::regex formats(
      "^(OpenImageIO|nlohmann|tiny_|tiny_gltf|png\\.h|jpeglib|OpenEXR)");
  for (const Include& include : includes("src/mq")) {
    if (room_of(include.file) == "io") continue;
    EXPECT_FALSE(std::regex_search(include.name, formats)) << include.where << ": " << include.name;
  }
}

TEST(Rooms, HaveAReadmeOfAtMostFortyLines) {
  for (const auto& entry : fs::directory_iterator(root / "src/mq")) {
    if (!entry.is_directory()) continue;
    const fs::path readme = entry.path() / "README.md";
    EXPECT_TRUE(fs::exists(readme)) << readme << " is missing: what enters, what leaves, its types";
    EXPECT_LE(lines_of(readme).size(), 40U) << readme;
  }
}

TEST(Headers, BeginWithPragmaOnce) {
  for (const char* folder : {"src", "apps", "tests"})
    for (const fs::path& file : sources(folder)) {
      if (file.extension() != ".h") continue;
      const auto lines = lines_of(file);
      ASSERT_FALSE(lines.empty()) << file;
      EXPECT_EQ(lines[0], "#pragma once") << file;
    }
}

TEST(Sources, LeaveNothingUnfinished) {
  static const std::regex marks(std::string("\\b(TO") + "DO|FIX" + "ME|XX" + "X)\\b");
  for (const char* folder : {"src", "apps", "tests", "bench"})
    for (const fs::path& file : sources(folder)) {
      const auto lines = lines_of(file);
      for (std::size_t i = 0; i < lines.size(); ++i)
        EXPECT_FALSE(std::regex_search(lines[i], marks)) << place(file, i);
    }
}

TEST(Library, NeverPrintsExitsOrSetsTheLocale) {
  static const std::regex calls(
      R"(\bstd::(cout|cerr|clog)\b|\b(printf|puts|fmt::print|setlocale|std::exit|std::abort)\s*\(|\bstd::locale::global\b)");
  for (const fs::path& file : sources("src/mq")) {
    const auto lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(lines[i], calls)) << place(file, i) << ": " << lines[i];
  }
}

TEST(Library, LeavesTheNumberOfThreadsToTheApplication) {
  for (const fs::path& file : sources("src/mq"))
    for (const std::string& line : lines_of(file))
      EXPECT_EQ(line.find("global_control("), std::string::npos) << file;
}

TEST(Library, TakesNoBoolParameters) {
  // A public function with a bool parameter reads as nothing where it is called; what a check
  // checks is no such parameter.
  static const std::regex parameter(
      R"([(,]\s*(const\s+)?bool\s+(?!condition)\w+\s*(=[^,)]*)?[,)])");
  for (const fs::path& file : sources("src/mq")) {
    if (file.extension() != ".h") continue;
    const auto lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(lines[i], parameter)) << place(file, i) << ": " << lines[i];
  }
}

}  // namespace
