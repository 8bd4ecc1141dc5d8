// Formulas say where they come from: headers cite keys of docs/references.bib in brackets, each key
// is cited somewhere, and none is cited that is not there.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "rules/sources.h"

namespace {

namespace fs = std::filesystem;

using mq::rules::root;
using mq::rules::text_of;

/// A name, a year and a word, as all keys but the thesis' are made.
const std::string key_pattern = "[a-z]+[0-9]{4}[a-z]+|prada_thesis";

std::set<std::string> keys_of_references() {
  static const std::regex entry("^@[a-z]+\\{([^,]+),");
  std::set<std::string> keys;
  std::ifstream file(root / "docs/references.bib");
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (!std::regex_search(line, match, entry)) continue;
    EXPECT_TRUE(keys.insert(match[1]).second) << "twice in references.bib: " << match[1];
    EXPECT_TRUE(std::regex_match(match[1].str(), std::regex(key_pattern)))
        << match[1] << ": a key is made of a name, a year and a word";
  }
  return keys;
}

/// Keys in brackets in headers, "[crane2013heat]" or "[a2013b, c2014d]", with a file that cites
/// each. Comments may break a line between two.
std::map<std::string, std::string> cited_in_headers() {
  static const std::regex group("\\[((" + key_pattern + ")(, *(" + key_pattern + "))*)\\]");
  static const std::regex key(key_pattern), line_break("\n *///?<? *");
  std::map<std::string, std::string> cited;
  for (const auto& entry : fs::recursive_directory_iterator(root / "src/mq")) {
    if (entry.path().extension() != ".h") continue;
    const std::string text = std::regex_replace(text_of(entry.path()), line_break, " ");
    for (std::sregex_iterator g(text.begin(), text.end(), group), end; g != end; ++g) {
      const std::string keys = (*g)[1];
      for (std::sregex_iterator k(keys.begin(), keys.end(), key); k != end; ++k)
        cited[k->str()] = fs::relative(entry.path(), root).string();
    }
  }
  return cited;
}

TEST(Citations, OfHeadersAreInTheReferences) {
  const auto keys = keys_of_references();
  const auto cited = cited_in_headers();
  ASSERT_GT(cited.size(), 20U);
  for (const auto& [key, place] : cited)
    EXPECT_TRUE(keys.contains(key)) << place << " cites [" << key << "], not in references.bib";
}

TEST(Citations, ReachEveryReference) {
  const auto cited = cited_in_headers();
  for (const std::string& key : keys_of_references())
    EXPECT_TRUE(cited.contains(key)) << "docs/references.bib: no header cites [" << key << "]";
}

TEST(Citations, OfPagesAreInTheReferences) {
  // Pages link them: [key](references.bib), [key, key](references.bib).
  static const std::regex link("\\[([^\\]]*)\\]\\((?:\\.\\./)?(?:docs/)?references\\.bib\\)");
  static const std::regex key(key_pattern);
  const auto keys = keys_of_references();
  int links = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = text_of(entry.path());
    for (std::sregex_iterator l(text.begin(), text.end(), link), end; l != end; ++l) {
      const std::string words = (*l)[1];
      for (std::sregex_iterator k(words.begin(), words.end(), key); k != end; ++k, ++links)
        EXPECT_TRUE(keys.contains(k->str())) << entry.path() << ": " << k->str();
    }
  }
  EXPECT_GT(links, 10);
}

}  // namespace
