// The one-definition rule, as far as it can be read from the sources: no type and no inline
// function is defined twice in one namespace with different contents. The linker does not say so;
// it takes either.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "rules/sources.h"

namespace {

namespace fs = std::filesystem;

/// Words and signs of a source; comments, directives and what is inside literals are left out.
std::vector<std::string> tokens_of(const std::string& text) {
  static const std::regex pattern(
      R"re(//[^\n]*|/\*[\s\S]*?\*/|(?:^|\n)[ \t]*#(?:\\\n|[^\n])*|R"(\w*)\([\s\S]*?\)\1"|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])+'|\d[\w'.]*|\w+|::|[^\s\w])re");
  std::vector<std::string> tokens;
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) {
    std::string token = i->str();
    if (token.starts_with("//") || token.starts_with("/*")) continue;
    if (token.find('#') != std::string::npos && token[token.find_first_not_of(" \t\n")] == '#')
      continue;
    tokens.push_back(std::move(token));
  }
  return tokens;
}

/// The token after the bracket that closes the one at `open`.
std::size_t after_bracket(const std::vector<std::string>& tokens, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < tokens.size(); ++i) {
    if (tokens[i] == "{" || tokens[i] == "(") ++depth;
    if (tokens[i] == "}" || tokens[i] == ")")
      if (--depth == 0) return i + 1;
  }
  return tokens.size();
}

std::string joined(const std::vector<std::string>& tokens, std::size_t begin, std::size_t end) {
  std::string text;
  for (std::size_t i = begin; i < std::min(end, tokens.size()); ++i) text += tokens[i] + ' ';
  return text;
}

bool is_name(const std::string& token) {
  return std::isalpha(static_cast<unsigned char>(token[0])) || token[0] == '_';
}

/// What a statement at namespace scope that ends in a body defines: "struct X", "f ( int a )", or
/// nothing that counts.
std::string defined(const std::vector<std::string>& statement) {
  static const std::set<std::string> type_words = {"struct", "class", "enum", "union"};
  std::size_t i = 0;
  if (std::ranges::find(statement, "template") != statement.end() &&
      std::ranges::find(statement, "<") != statement.end())
    return "";  // templates and their specialisations share names
  for (; i < statement.size(); ++i) {
    if (type_words.contains(statement[i])) {
      while (i + 1 < statement.size() && type_words.contains(statement[i + 1])) ++i;
      if (i + 1 >= statement.size() || !is_name(statement[i + 1])) return "";
      if (i + 2 < statement.size() && statement[i + 2] == "::") return "";  // a member of another
      return "type " + statement[i + 1];
    }
    if (statement[i] == "(") break;
  }
  if (i == 0 || i == statement.size() || !is_name(statement[i - 1])) return "";
  if (i >= 2 && statement[i - 2] == "::") return "";  // a member: its class is looked at
  return statement[i - 1] + " " + joined(statement, i, after_bracket(statement, i));
}

struct Definition {
  std::string where, body;
};
using Definitions = std::map<std::string, std::vector<Definition>>;

/// Adds what `tokens` define in namespaces that have a name.
void collect(const std::vector<std::string>& tokens, const std::string& where, Definitions& all) {
  std::vector<std::string> scopes, statement;
  for (std::size_t i = 0; i < tokens.size();) {
    const std::string& token = tokens[i];
    if (token == ";") {
      statement.clear();
      ++i;
    } else if (token == "}") {
      if (!scopes.empty()) scopes.pop_back();
      statement.clear();
      ++i;
    } else if (token == "{" && !statement.empty() && statement[0] == "namespace") {
      scopes.push_back(joined(statement, 1, statement.size()));
      statement.clear();
      ++i;
    } else if (token == "{") {
      const std::size_t end = after_bracket(tokens, i);
      const bool local = std::ranges::find(scopes, "") != scopes.end() ||
                         (!statement.empty() && statement[0] == "static");
      if (const std::string name = defined(statement); !name.empty() && !local) {
        std::string scope;
        for (const std::string& s : scopes) scope += s + ":: ";
        all[scope + name].push_back({where, joined(tokens, i, end)});
      }
      if (end < tokens.size() && tokens[end] != ";") statement.clear();
      i = end;
    } else {
      statement.push_back(token);
      ++i;
    }
  }
}

/// What is defined more than once, with different contents, in these texts by name.
std::vector<std::string> defined_twice(const std::map<std::string, std::string>& texts) {
  Definitions all;
  for (const auto& [where, text] : texts) collect(tokens_of(text), where, all);
  std::vector<std::string> twice;
  for (const auto& [name, definitions] : all)
    for (const Definition& definition : definitions)
      if (definition.body != definitions[0].body) {
        twice.push_back(name + " in " + definitions[0].where + " and " + definition.where);
        break;
      }
  return twice;
}

/// Sources below `folder`, by path.
std::map<std::string, std::string> texts_of(const std::string& folder) {
  std::map<std::string, std::string> texts;
  using mq::rules::root;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    texts[fs::relative(entry.path(), root).string()] = mq::rules::text_of(entry.path());
  }
  return texts;
}

TEST(Names, AreDefinedOnceInTheLibrary) {
  std::map<std::string, std::string> texts = texts_of("src");
  ASSERT_GT(texts.size(), 100U);
  for (const std::string& twice : defined_twice(texts)) ADD_FAILURE() << twice;
}

TEST(Names, AreDefinedOnceInEachProgram) {
  // The viewer and marquetry-mpi link the verbs; of the programs only `main` differs.
  std::map<std::string, std::string> texts = texts_of("apps");
  texts.erase("apps/viewer/main.cpp");
  texts.erase("apps/mpi/main.cpp");
  texts.merge(texts_of("src"));
  for (const std::string& twice : defined_twice(texts)) ADD_FAILURE() << twice;
}

TEST(Names, DefinedTwiceAreFound) {
  const auto found = [](const std::string& first, const std::string& second) {
    return defined_twice({{"a.h", first}, {"b.h", second}}).size();
  };
  EXPECT_EQ(found("namespace mq { struct A { int a; }; }", "namespace mq { class A { int b; }; }"),
            1U);
  EXPECT_EQ(found("namespace mq { enum class A { x }; }", "namespace mq { enum class A { y }; }"),
            1U);
  EXPECT_EQ(found("namespace mq { inline int f(int a) { return a; } }",
                  "namespace mq { inline int f(int a) { return -a; } }"),
            1U);
  EXPECT_EQ(
      found("namespace mq { struct A { int a; }; }", "namespace mq { struct A { int a; /* */ }; }"),
      0U);
  EXPECT_EQ(
      found("namespace mq { struct A { int a; }; }", "namespace mq::app { struct A { int b; }; }"),
      0U);
  EXPECT_EQ(found("namespace mq { struct A { int a; }; }",
                  "namespace mq { namespace { struct A { int b; }; } }"),
            0U);
  EXPECT_EQ(found("namespace mq { int f(int a) { return a; } }",
                  "namespace mq { int f(double a) { return -a; } }"),
            0U);
}

}  // namespace
