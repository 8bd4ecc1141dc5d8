// The documentation says what the program says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "cli/program.h"
#include "places.h"

namespace mq::test {
namespace {

const std::filesystem::path docs = places::source() / "docs";

/// What the program says of itself; each question is asked once.
const std::string& said(const std::vector<std::string>& words) {
  static std::map<std::vector<std::string>, std::string> answers;
  const auto found = answers.find(words);
  if (found != answers.end()) return found->second;
  return answers[words] = marquetry({}, words).output;
}

/// The first word of each indented line of the list of verbs.
std::set<std::string> verbs() {
  const std::string& overview = said({"--help"});
  static const std::regex line("(^|\n)  ([a-z]+) ");
  std::set<std::string> names;
  for (auto it = std::sregex_iterator(overview.begin(), overview.end(), line);
       it != std::sregex_iterator(); ++it)
    names.insert((*it)[2]);
  return names;
}

/// What a page has between its marks when it holds what `marquetry help WORD` says.
std::string block_of(const std::string& word) {
  return "<!-- options -->\n```text\n" + said({"help", word}) + "```\n<!-- end of options -->\n";
}

/// Names of options at the beginning of the entries of a help page.
std::set<std::string> options_in(const std::string& help) {
  static const std::regex entry("\n  (?:-[a-z], )?(--[a-z-]+)");
  std::set<std::string> names;
  for (auto it = std::sregex_iterator(help.begin(), help.end(), entry);
       it != std::sregex_iterator(); ++it)
    names.insert((*it)[1]);
  return names;
}

TEST(Docs, HaveAPageWithItsOwnOptionsForEveryVerb) {
  ASSERT_GE(verbs().size(), 5U);
  for (const std::string& verb : verbs()) {
    const std::string page = file_bytes(docs / (verb + ".md"));
    ASSERT_FALSE(page.empty()) << "docs/" << verb << ".md is missing";
    EXPECT_NE(page.find(block_of(verb)), std::string::npos)
        << "docs/" << verb << ".md does not hold the options as they are: run scripts/docs";
  }
}

TEST(Docs, HaveOptionsThatVerbsShareOnAPageOfTheirOwn) {
  EXPECT_NE(file_bytes(docs / "common_options.md").find(block_of("options")), std::string::npos)
      << "docs/common_options.md does not hold the options as they are: run scripts/docs";
}

TEST(Docs, SayWhichVerbWorksOnWhichSignals) {
  const std::string table = said({"help", "signals"});
  EXPECT_NE(table.find("(`filter`) | yes | yes | yes |"), std::string::npos) << table;
  EXPECT_NE(file_bytes(docs / "README.md").find("<!-- signals -->\n" + table + "<!-- end of signals -->"),
            std::string::npos)
      << "docs/README.md does not hold the table as it is: run scripts/docs";
}

TEST(Docs, LeaveNoOptionOut) {
  const std::set<std::string> shared = options_in(said({"help", "options"}));
  ASSERT_GE(shared.size(), 10U);
  for (const std::string& verb : verbs()) {
    const std::string& own = said({"help", verb});
    const std::set<std::string> here = options_in(own);
    for (const std::string& option : options_in(said({verb, "--help"}))) {
      EXPECT_TRUE(here.contains(option) || shared.contains(option)) << verb << " " << option;
      // What is left to the other page is at least named.
      EXPECT_NE(own.find(option), std::string::npos) << verb << " " << option;
    }
  }
}

TEST(Docs, ExplainEveryKeyOfAReport) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "bust", "--size", "64", "-o", "./"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"render", "bust.obj", "--size", "64", "-o", "view.png", "--cameras", "view.json"}).status, 0);
  const std::vector<std::vector<std::string>> runs = {
      {"cameras", "view.json", "--mesh", "bust.obj"},
      {"inspect", "bust.obj"},
      {"check", "bust.obj"},
      {"mask", "bust.obj", "-o", "out.png"},
      {"filter", "bust.obj", "--beta", "2", "-o", "out.png"},
      {"seams", "bust.obj", "-o", "out.png"},
      {"fill", "bust.obj", "-o", "out.png"},
      {"bake", "bust.obj", "bust.obj", "-o", "out.png"},
      {"geodesic", "bust.obj", "--from", "0,0.3,1", "-o", "out.png"},
      {"react", "bust.obj", "--time", "20", "--scale", "12tx", "-o", "out.png"}};
  const std::string shared = file_bytes(docs / "reports.md") + file_bytes(docs / "filter.md");
  for (std::vector<std::string> words : runs) {
    const std::string verb = words[0];
    words.insert(words.end(), {"--json", "--quiet"});
    const nlohmann::json report = marquetry(folder, words).json();
    const std::string page = file_bytes(docs / (verb + ".md")) + shared;
    for (const auto& [key, value] : report.at("result").items())
      EXPECT_NE(page.find("`" + key + "`"), std::string::npos) << verb << ": result." << key;
    for (const auto& [key, value] : report.items())
      EXPECT_NE(page.find("`" + key + "`"), std::string::npos) << verb << ": " << key;
  }
}

TEST(Docs, ListEveryVerb) {
  const std::string index = file_bytes(docs / "README.md");
  for (const std::string& verb : verbs())
    EXPECT_NE(index.find("(" + verb + ".md)"), std::string::npos) << verb;
}

}  // namespace
}  // namespace mq::test
