// A room's README names types, functions and headers that exist.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "rules/sources.h"

namespace {

namespace fs = std::filesystem;

using mq::rules::root;
using mq::rules::text_of;

TEST(Readmes, NameWhatExists) {
  static const std::regex word("[A-Za-z_][A-Za-z_0-9]*"), code("`([^`\n]+)`"),
      name("[A-Z][A-Za-z0-9]*[a-z][A-Za-z0-9]*|[a-z0-9]+(_[a-z0-9]+)+"),
      header("(\\w+/)?(\\w+\\.h)");
  std::set<std::string> words, headers;
  for (const auto& entry : fs::recursive_directory_iterator(root / "src/mq")) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    headers.insert(entry.path().filename().string());
    words.insert(entry.path().stem().string());
    const std::string text = text_of(entry.path());
    for (std::sregex_iterator w(text.begin(), text.end(), word), end; w != end; ++w)
      words.insert(w->str());
  }
  int names = 0;
  for (const auto& room : fs::directory_iterator(root / "src/mq")) {
    if (!room.is_directory()) continue;
    const fs::path readme = room.path() / "README.md";
    const std::string text = text_of(readme);
    for (std::sregex_iterator c(text.begin(), text.end(), code), end; c != end; ++c) {
      const std::string words_of_code = (*c)[1];
      std::smatch match;
      if (std::regex_match(words_of_code, match, header)) {
        EXPECT_TRUE(headers.contains(match[2])) << readme << ": there is no header " << match[0];
      } else if (std::regex_match(words_of_code, name)) {
        ++names;
        EXPECT_TRUE(words.contains(words_of_code))
            << readme << ": nothing is called " << words_of_code;
      }
    }
  }
  EXPECT_GT(names, 50);
}

}  // namespace
