// The rules of the house that a compiler does not check, read from the sources.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "rules/sources.h"

namespace {

namespace fs = std::filesystem;

using mq::rules::root;

/// In the order data flows: a room includes itself and the rooms before it.
const std::vector<std::string> rooms = {
    "base",   "linear", "image", "mesh",  "remesh", "unwrap", "atlas", "fem",   "evolving", "trace",
    "filter", "flow",   "track", "video", "draw",   "views",  "sample", "io",    "model", "baseline"};

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

TEST(Rooms, KeepOpenImageIoInTheFilesOfPictures) {
  int found = 0;
  for (const Include& include : includes("src/mq")) {
    if (!include.name.starts_with("OpenImageIO/")) continue;
    ++found;
    const std::string file = fs::relative(include.file, root / "src/mq/io").generic_string();
    EXPECT_TRUE(file == "image_file.cpp" || file.starts_with("detail/picture_")) << include.where;
  }
  EXPECT_GT(found, 0);
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

TEST(Sources, HaveAtMostFiveHundredLines) {
  for (const char* folder : {"src", "apps", "tests", "bench", "examples"})
    for (const fs::path& file : sources(folder)) {
      if (file.extension() != ".cpp") continue;
      EXPECT_LE(lines_of(file).size(), 500U) << fs::relative(file, root) << ": split it by purpose";
    }
}

/// A function at namespace scope: where its head begins, and how many lines it has.
struct Function {
  std::size_t begin, lines;
};

/// Functions whose head begins in column 0 and ends with a brace, and whose body ends with a line
/// that is a brace alone.
std::vector<Function> functions_in(const std::vector<std::string>& lines) {
  std::vector<Function> functions;
  std::optional<std::size_t> begin;
  bool in_body = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (in_body) {
      if (line == "}") functions.push_back({*begin, i + 1 - *begin});
      in_body = line != "}" && line != "};";  // the latter ends a type or a table
      continue;
    }
    if (!line.empty() && std::isalpha(static_cast<unsigned char>(line[0]))) begin = i;
    if (line.empty() || line.starts_with("namespace")) begin.reset();
    if (line.ends_with(";") || line.ends_with("}"))
      begin.reset();  // it has no body, or in one line
    in_body = begin && line.ends_with("{");
  }
  return functions;
}

TEST(Functions, HaveAtMostEightyLines) {
  std::size_t found = 0;
  for (const char* folder : {"src", "apps"})
    for (const fs::path& file : sources(folder)) {
      if (file.parent_path().filename() == "kernels") continue;
      const auto lines = lines_of(file);
      for (const Function& function : functions_in(lines)) {
        ++found;
        EXPECT_LE(function.lines, 80U)
            << place(file, function.begin) << ": " << lines[function.begin] << ": split it";
      }
    }
  EXPECT_GT(found, 1000U);
}

TEST(Functions, AreFoundWithTheirLengths) {
  const auto lengths = [](const std::vector<std::string>& lines) {
    std::vector<std::size_t> found;
    for (const Function& function : functions_in(lines)) found.push_back(function.lines);
    return found;
  };
  using Lengths = std::vector<std::size_t>;
  EXPECT_EQ(lengths({"void f() {", "  g();", "", "}"}), Lengths{4});
  EXPECT_EQ(lengths({"int f(int a,", "      int b) {", "  if (a) {", "  }", "}"}), Lengths{5});
  EXPECT_EQ(lengths({"A::A()", "    : b_(1) {", "}", "void f() {", "}"}), (Lengths{3, 2}));
  EXPECT_EQ(lengths({"template <class T>", "void f() {", "}"}), Lengths{2});
  EXPECT_EQ(lengths({"void f();", "void f() {}", "int a = 1;", "  {", "}"}), Lengths{});
  EXPECT_EQ(lengths({"namespace {", "struct A {", "  int a;", "};", "}  // namespace"}), Lengths{});
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

TEST(Library, NamesOptionsByTheirFields) {
  // What a program calls them `option_name` says. These name options of others, or are about tables.
  static const std::set<std::string> others = {"options.cpp", "options.h", "option_names.h",
                                               "eigen_alignment.h", "cameras.cpp"};
  static const std::regex option(R"x("[^"]*--[a-z][a-z-]+[^"]*")x");
  for (const fs::path& file : sources("src/mq")) {
    if (others.contains(file.filename().string())) continue;
    const auto lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(lines[i], option)) << place(file, i) << ": " << lines[i];
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
