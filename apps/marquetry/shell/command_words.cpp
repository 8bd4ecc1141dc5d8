#include "shell/command_words.h"

#include <algorithm>
#include <cctype>

namespace mq::app {
namespace {

bool is_plain(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string("_-+=./,:%@").find(char(c)) != std::string::npos;
  };
  return !word.empty() && std::ranges::all_of(word, plain);
}

/// In single quotes, where nothing has a meaning but the quote itself.
std::string quoted(const std::string& word) {
  if (is_plain(word)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::vector<std::string> command_words(const OptionValues& options) {
  std::vector<std::string> words = {options.table().verb()}, positional;
  for (const Option& option : options.table().options()) {
    if (!options.given(option.name)) continue;
    if (option.place == Option::Place::positional) {
      for (const std::string& text : options.texts(option.name)) positional.push_back(text);
    } else if (option.type == Option::Type::flag) {
      if (options.flag(option.name)) words.push_back("--" + option.name);
    } else {
      for (const std::string& text : options.texts(option.name))
        words.push_back("--" + option.name + "=" + text);
    }
  }
  const auto hyphen = [](const std::string& word) { return word.starts_with('-'); };
  if (std::ranges::any_of(positional, hyphen)) words.emplace_back("--");
  words.insert(words.end(), positional.begin(), positional.end());
  return words;
}

std::string command_line(const OptionValues& options) {
  std::string line = "marquetry";
  for (const std::string& word : command_words(options)) line += " " + quoted(word);
  return line;
}

}  // namespace mq::app
