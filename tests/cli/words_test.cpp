// Manual pages and completions say what the option tables say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "cli/program.h"

namespace mq::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// What a regular expression's first group finds.
std::set<std::string> found(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  std::set<std::string> all;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), expression);
       it != std::sregex_iterator(); ++it)
    all.insert((*it)[1]);
  return all;
}

std::string all_said(const std::vector<std::string>& words) {
  const Result result = marquetry({}, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return result.output;
}

/// Per verb its options, "--output" and so on: the first words of the lines of its help.
const std::map<std::string, std::set<std::string>>& options_of_verbs() {
  static const auto all = [] {
    std::map<std::string, std::set<std::string>> options;
    for (const std::string& verb : found(all_said({"--help"}), "\n  ([a-z]+) "))
      options[verb] = found(all_said({verb, "--help"}), "\n  (?:-[a-zA-Z], )?(--[a-z0-9-]+)");
    return options;
  }();
  return all;
}

bool has_program(const std::string& name) {
  return std::system(("command -v " + name + " > /dev/null").c_str()) == 0;
}

/// What a command of the shell prints, errors included.
std::string printed(const std::string& command) {
  FILE* pipe = popen(("exec 2>&1; " + command).c_str(), "r");
  std::string all;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) all += char(c);
  EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 0) << command << "\n" << all;
  return all;
}

/// The words that bash completes a command line with, whose last word is the one to complete.
std::set<std::string> completed(const std::vector<std::string>& words) {
  const Folder folder;
  write_bytes(folder / "completion", all_said({"--completion", "bash"}));
  std::string line;
  for (const std::string& word : words) line += "'" + word + "' ";
  write_bytes(folder / "ask",
              ". '" + (folder / "completion").string() + "'\ncompopt() { :; }\nCOMP_WORDS=(marquetry " + line +
                  ")\nCOMP_CWORD=" + std::to_string(words.size()) +
                  "\n_marquetry\nfor word in \"${COMPREPLY[@]}\"; do echo \"$word\"; done\n");
  return found("\n" + printed("bash '" + (folder / "ask").string() + "'"), "\n([^\n]+)(?=\n)");
}

TEST(Help, HasExamplesOfEveryVerbThatItUnderstands) {
  for (const auto& [verb, options] : options_of_verbs()) {
    const std::set<std::string> examples = found(all_said({verb, "-h"}), "\n  marquetry [a-z]+ ([^\n]+)\n      [^\n]+");
    EXPECT_FALSE(examples.empty()) << verb;
    for (const std::string& example : examples) {
      std::vector<std::string> words{verb};
      std::istringstream all(example);
      for (std::string word; all >> word;) words.push_back(word);
      if (words.back() != "--dry-run") words.emplace_back("--dry-run");
      const Result result = marquetry({}, words);
      // Nothing is wrong with it but that the files are not here.
      EXPECT_TRUE(result.status == 0 || result.error.find("o such file") != std::string::npos ||
                  result.error.find("no file is called so") != std::string::npos)
          << example << "\n" << result.error;
    }
  }
}

TEST(ManualPages, HaveNothingThatManWarnsOf) {
  if (!has_program("man")) GTEST_SKIP() << "there is no man";
  const Folder folder;
  std::vector<std::vector<std::string>> pages = {{"--manual"}};
  for (const auto& [verb, options] : options_of_verbs()) pages.push_back({"--manual", verb});
  for (const auto& words : pages) {
    write_bytes(folder / "page.1", all_said(words));
    EXPECT_THAT(printed("LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -E UTF-8 -l '" +
                        (folder / "page.1").string() + "' > /dev/null"),
                IsEmpty())
        << words.back();
  }
}

TEST(ManualPages, NameEveryVerbAndEveryOption) {
  const std::string all = all_said({"--manual"});
  ASSERT_GE(options_of_verbs().size(), 20U);
  for (const auto& [verb, options] : options_of_verbs()) {
    EXPECT_THAT(all, HasSubstr("fBmarquetry\\-" + verb + "\\fR(1)"));
    const std::string page = all_said({"--manual", verb});
    EXPECT_THAT(page, HasSubstr("marquetry\\-" + verb + " \\- ")) << "has no NAME that whatis finds";
    for (const std::string& option : options)
      EXPECT_THAT(page, HasSubstr("\\fB" + std::regex_replace(option, std::regex("-"), "\\-") + "\\fR"))
          << verb;
  }
  EXPECT_EQ(marquetry({}, {"--manual", "filtre"}).status, 2);
}

TEST(Completion, KnowsEveryVerbAndEveryOption) {
  ASSERT_THAT(completed({""}), Contains("filter"));
  std::set<std::string> first = {"--help", "--version"};
  for (const auto& [verb, options] : options_of_verbs()) first.insert(verb);
  EXPECT_EQ(completed({""}), first);
  const std::string zsh = all_said({"--completion", "zsh"}), fish = all_said({"--completion", "fish"});
  for (const auto& [verb, options] : options_of_verbs()) {
    std::set<std::string> expected = options;
    expected.insert("--help");
    EXPECT_EQ(completed({verb, "--"}), expected) << verb;
    EXPECT_THAT(zsh, HasSubstr("\n    '" + verb + ":"));
    EXPECT_THAT(fish, HasSubstr(" -a " + verb + " -d "));
    const std::size_t begin = zsh.find("\n    " + verb + ")\n");
    ASSERT_NE(begin, std::string::npos) << verb;
    const std::string part = zsh.substr(begin, zsh.find(" ;;", begin) - begin);
    for (const std::string& option : options) {
      EXPECT_THAT(part, testing::AnyOf(HasSubstr(option + "["), HasSubstr(option + "}"))) << verb;
      EXPECT_THAT(fish, testing::ContainsRegex("__marquetry_verb " + verb + "' -l " +
                                               option.substr(2) + "( |\n)"));
    }
  }
  EXPECT_THAT(marquetry({}, {"--completion", "csh"}).error, HasSubstr("bash, zsh or fish"));
}

TEST(Completion, OfBashFindsOptionsAndChoices) {
  EXPECT_THAT(completed({"filter", "--al"}), UnorderedElementsAre("--alpha"));
  EXPECT_THAT(completed({"filter", "bust.obj", "--space", ""}), testing::IsSupersetOf({"linear", "log"}));
  EXPECT_THAT(completed({"filter", "bust.obj", "--space", "li"}), UnorderedElementsAre("linear"));
  EXPECT_THAT(completed({"filter", "bust.obj", "--space", "=", "li"}), UnorderedElementsAre("linear"));
  EXPECT_THAT(completed({"filter", "bust.obj", "--space", "="}), Contains("log"));
  EXPECT_THAT(completed({"filter", "-o", "b"}), IsEmpty()) << "bash itself completes names of files";
}

TEST(Completion, IsReadByItsShells) {
  const Folder folder;
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    if (!has_program(shell)) continue;
    write_bytes(folder / shell, all_said({"--completion", shell}));
    EXPECT_THAT(printed(shell + " -n '" + (folder / shell).string() + "'"), IsEmpty()) << shell;
  }
  if (!has_program("fish")) GTEST_SKIP() << "there is no fish";
  const std::string completions =
      printed("cd '" + folder.path().string() + "' && HOME=$PWD fish --no-config -c "
              "'source fish; complete -C \"marquetry filter --space l\"; complete -C \"marquetry fil\"'");
  EXPECT_THAT(completions, HasSubstr("linear"));
  EXPECT_THAT(completions, HasSubstr("filter\t"));
}

}  // namespace
}  // namespace mq::test
