// The version stands in few places, and in all of them it is the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "mq/version.h"
#include "rules/sources.h"

namespace mq::test {
namespace {

using testing::Each;
using testing::IsEmpty;
using testing::Not;

/// What the first group of a regular expression finds in a file of the sources.
std::vector<std::string> found(const std::string& file, const std::string& pattern) {
  const std::string text = rules::text_of(rules::root / file);
  const std::regex expression(pattern);
  std::vector<std::string> all;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), expression); it != std::sregex_iterator(); ++it)
    all.push_back((*it)[1]);
  return all;
}

TEST(Releases, HaveOneVersion) {
  const std::vector<std::pair<std::string, std::string>> places = {
      {"CITATION.cff", "\nversion: (\\S+)"},
      {"blender/marquetry_blender/blender_manifest.toml", "\nversion = \"([^\"]+)\""},
      {"docs/install.md", "marquetry(?:-dev)?_([0-9.]+)-1_amd64.deb"}};
  for (const auto& [file, pattern] : places) {
    EXPECT_THAT(found(file, pattern), Not(IsEmpty())) << file;
    EXPECT_THAT(found(file, pattern), Each(std::string(version))) << file;
  }
}

TEST(Releases, HaveTheirChangesOnTop) {
  const auto headings = found("CHANGELOG.md", "\n## ([0-9.]+), (?:not released yet|[0-9]{4}-[0-9]{2}-[0-9]{2})\n");
  ASSERT_THAT(headings, Not(IsEmpty()));
  EXPECT_EQ(headings.front(), version);
}

}  // namespace
}  // namespace mq::test
