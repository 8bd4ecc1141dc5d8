// The documentation says what the program says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "cli/program.h"
#include "places.h"

namespace mq::test {
namespace {

const std::filesystem::path docs = places::source() / "docs";

/// The first word of each indented line of the list of verbs.
std::set<std::string> verbs() {
  const std::string overview = marquetry({}, {"--help"}).output;
  static const std::regex line("(^|\n)  ([a-z]+) ");
  std::set<std::string> names;
  for (auto it = std::sregex_iterator(overview.begin(), overview.end(), line);
       it != std::sregex_iterator(); ++it)
    names.insert((*it)[2]);
  return names;
}

TEST(Docs, HaveAPageWithAllOptionsForEveryVerb) {
  ASSERT_GE(verbs().size(), 5U);
  for (const std::string& verb : verbs()) {
    const std::string page = file_bytes(docs / (verb + ".md"));
    ASSERT_FALSE(page.empty()) << "docs/" << verb << ".md is missing";
    const std::string block = "<!-- options -->\n```text\n" +
                              marquetry({}, {verb, "--help"}).output +
                              "```\n<!-- end of options -->\n";
    EXPECT_NE(page.find(block), std::string::npos)
        << "docs/" << verb << ".md does not hold the options as they are: run scripts/docs";
  }
}

TEST(Docs, ListEveryVerb) {
  const std::string index = file_bytes(docs / "README.md");
  for (const std::string& verb : verbs())
    EXPECT_NE(index.find("(" + verb + ".md)"), std::string::npos) << verb;
}

TEST(Docs, ShowOnlyPicturesAndPagesThatAreThere) {
  static const std::regex link(R"(\]\(([^)#:]+)\))");
  int links = 0;
  std::vector<std::filesystem::path> pages = {places::source() / "README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(docs))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  for (const auto& page : pages) {
    const std::string text = file_bytes(page);
    for (auto it = std::sregex_iterator(text.begin(), text.end(), link);
         it != std::sregex_iterator(); ++it, ++links)
      EXPECT_TRUE(std::filesystem::exists(page.parent_path() / (*it)[1].str()))
          << page << ": " << (*it)[1];
  }
  EXPECT_GT(links, 10);
}

}  // namespace
}  // namespace mq::test
