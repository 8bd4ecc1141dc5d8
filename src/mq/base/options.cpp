// A value is kept as the text a user typed, once it has been checked against its row of the table;
// it is turned into a number each time it is read. So a report repeats exactly what was typed, and
// there is one representation to hand to help, JSON and configuration files.
#include "mq/base/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/base/option_words.h"

namespace mq {
namespace {

/// The number that is all of `text`; nothing when there is more, or less, or it is not finite.
template <class T>
std::optional<T> parse(const std::string& text) {
  T value{};
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(double(value))) return std::nullopt;
  return value;
}

/// A number as it is kept: one in percent may be typed with its sign.
std::string plain(const Option& option, const std::string& text) {
  const bool in_percent = option.type == Option::Type::number && option.unit.starts_with('%');
  return in_percent && text.ends_with('%') ? text.substr(0, text.size() - 1) : text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (std::size_t i = 0; i < words.size(); ++i)
    all += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return all;
}

constexpr const char* infinity_text = "inf";

/// "from 0 to 100", "at least 1", or nothing.
std::string range_text(const Option& option) {
  const bool below = std::isfinite(option.least), above = std::isfinite(option.most);
  if (below && above)
    return fmt::format("from {:.15g} to {:.15g}{}", option.least, option.most,
                       option.infinite ? " or inf" : "");
  if (below) return fmt::format("at least {:.15g}", option.least);
  if (above) return fmt::format("at most {:.15g}", option.most);
  return "";
}

/// What a value of this option has to be.
std::string wanted(const Option& option) {
  const std::string range = range_text(option);
  const std::string tail =
      (range.empty() ? "" : " " + range) + (option.unit.empty() ? "" : " (" + option.unit + ")");
  switch (option.type) {
    case Option::Type::flag: return "true or false";
    case Option::Type::integer: return "a whole number" + tail;
    case Option::Type::number: return "a number" + tail;
    case Option::Type::length:
      return option.wanted.empty() ? "a length such as 0.02, 1% or 8tx" : option.wanted;
    case Option::Type::choice: return joined(option.choices);
    case Option::Type::path: return "the name of a file or folder";
    case Option::Type::text: break;
  }
  return option.wanted.empty() ? "some text" : option.wanted;
}

bool in_range(const Option& option, double value) {
  return value >= option.least && value <= option.most;
}

bool is_length(const std::string& text) {
  try {
    parse_length(text);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

bool acceptable(const Option& option, const std::string& text) {
  switch (option.type) {
    case Option::Type::flag: return text == "true" || text == "false";
    case Option::Type::integer: {
      const auto value = parse<std::int64_t>(text);
      return value && in_range(option, double(*value));
    }
    case Option::Type::number: {
      const auto value = parse<double>(plain(option, text));
      return value ? in_range(option, *value) : option.infinite && text == infinity_text;
    }
    case Option::Type::length: return is_length(text) && (!option.accepts || option.accepts(text));
    case Option::Type::choice: return std::ranges::count(option.choices, text) > 0;
    case Option::Type::path: return !text.empty() && text.find('\0') == std::string::npos;
    case Option::Type::text: return option.accepts ? option.accepts(text) : !text.empty();
  }
  return false;
}

void check_value(const Option& option, const std::string& text) {
  if (acceptable(option, text)) return;
  const std::string found = text.substr(0, text.find('\0'));  // the system's names end there
  const std::string hint =
      option.type == Option::Type::choice ? did_you_mean(text, option.choices) : "";
  throw InvalidInput(
      fmt::format("{}: found '{}', wanted {}{}", display_name(option), found, wanted(option), hint));
}

std::vector<std::string> option_names(const OptionTable& table) {
  std::vector<std::string> names;
  for (const Option& option : table.options())
    if (option.place == Option::Place::named) names.push_back(option.name);
  return names;
}

/// The exclusive groups that `name` belongs to, as one list of its rivals.
std::vector<std::string> rivals(const OptionTable& table, const std::string& name) {
  std::vector<std::string> others;
  for (const auto& group : table.exclusives())
    if (std::ranges::count(group, name))
      std::ranges::copy_if(group, std::back_inserter(others),
                           [&](const std::string& other) { return other != name; });
  return others;
}

}  // namespace

OptionTable::OptionTable(std::string verb, std::string summary)
    : verb_(std::move(verb)), summary_(std::move(summary)) {}

OptionTable& OptionTable::add(Option option) {
  for (const Option& other : options_)
    if (other.name == option.name)
      throw std::logic_error("option " + option.name + " is in the table twice");
  if (const auto found = defaults_.find(option.name); found != defaults_.end()) option.default_value = found->second;
  if (!option.default_value.empty()) check_value(option, option.default_value);
  options_.push_back(std::move(option));
  return *this;
}

OptionTable& OptionTable::example(std::string words, std::string use) {
  examples_.emplace_back(std::move(words), std::move(use));
  return *this;
}

OptionTable& OptionTable::exclusive(std::vector<std::string> names) {
  exclusives_.push_back(std::move(names));
  return *this;
}

OptionTable& OptionTable::elsewhere(std::string name, std::string where) {
  elsewhere_.emplace(std::move(name), std::move(where));
  return *this;
}

OptionTable& OptionTable::with_default(std::string name, std::string value) {
  defaults_.emplace(std::move(name), std::move(value));
  return *this;
}

OptionTable& OptionTable::of_program(std::string name) {
  program_ = std::move(name);
  return *this;
}

const Option& OptionTable::find(const std::string& name) const {
  for (const Option& option : options_)
    if (option.name == name) return option;
  if (const auto found = elsewhere_.find(name); found != elsewhere_.end())
    throw InvalidInput(fmt::format("there is no option '--{}': {}", name, found->second));
  const std::string best = nearest(name, option_names(*this));
  const std::string hint = best.empty() ? "" : fmt::format(", did you mean '--{}'?", best);
  throw InvalidInput(fmt::format("there is no option '--{}'{} ('{} --help' lists them)",
                                 name, hint, command()));
}

OptionValues::OptionValues(OptionTable table) : table_(std::move(table)) {}

void OptionValues::set(const std::string& name, const std::vector<std::string>& values) {
  const Option& option = table_.find(name);
  require(option.count == Option::Count::many || values.size() == 1,
          display_name(option) + " takes one value");
  for (const std::string& value : values) check_value(option, value);
  std::vector<std::string>& given = given_[name];
  given.clear();
  for (const std::string& value : values) given.push_back(plain(option, value));
}

void OptionValues::reset(const std::string& name) { given_.erase(table_.find(name).name); }

bool OptionValues::given(const std::string& name) const { return given_.contains(name); }

bool OptionValues::has(const std::string& name) const { return !effective(name).empty(); }

std::vector<std::string> OptionValues::effective(const std::string& name) const {
  if (const auto found = given_.find(name); found != given_.end()) return found->second;
  const Option& option = table_.find(name);
  if (option.type == Option::Type::flag) return {"false"};
  if (option.default_value.empty()) return {};
  for (const std::string& rival : rivals(table_, name))
    if (given(rival)) return {};
  return {option.default_value};
}

std::vector<std::string> OptionValues::texts(const std::string& name) const {
  return effective(name);
}

const std::string& OptionValues::single(const std::string& name) const {
  if (const auto found = given_.find(name); found != given_.end()) return found->second.front();
  if (!has(name)) throw std::logic_error("option " + name + " has no value");
  return table_.find(name).default_value;
}

std::string OptionValues::text(const std::string& name) const { return single(name); }

bool OptionValues::flag(const std::string& name) const { return effective(name).front() == "true"; }

std::int64_t OptionValues::integer(const std::string& name) const {
  return parse<std::int64_t>(single(name)).value();
}

double OptionValues::number(const std::string& name) const {
  const std::string text = single(name);
  return text == infinity_text ? std::numeric_limits<double>::infinity()
                               : parse<double>(text).value();
}

void OptionValues::check() const {
  for (const auto& group : table_.exclusives()) {
    std::vector<std::string> together;
    for (const std::string& name : group)
      if (given(name) && single(name) != "false")
        together.push_back(display_name(table_.find(name)));
    require(together.size() < 2, fmt::format("{} contradict each other: give one of them",
                                             fmt::join(together, " and ")));
  }
  for (const Option& option : table_.options())
    require(!option.required || has(option.name),
            fmt::format("{} is missing: {}", display_name(option), option.help));
}

namespace {

/// Reads words in order, filling `found`.
class ArgumentReader {
 public:
  explicit ArgumentReader(const OptionTable& table) : table_(table) {
    for (const Option& option : table.options())
      if (option.place == Option::Place::positional) places_.push_back(&option);
  }

  OptionValues read(const std::vector<std::string>& words) {
    bool only_positional = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (only_positional || words[i].size() < 2 || words[i][0] != '-')
        give_positional(words[i]);
      else if (words[i] == "--")
        only_positional = true;
      else if (words[i][1] == '-')
        read_long(words, i);
      else
        read_short(words, i);
    }
    OptionValues values(table_);
    for (const auto& [name, texts] : found_) values.set(name, texts);
    return values;
  }

 private:
  void give(const Option& option, const std::string& value) {
    check_value(option, value);
    auto& values = found_[option.name];
    if (!values.empty() && option.count == Option::Count::one)
      throw InvalidInput(fmt::format("{} is given twice: '{}' and '{}'", display_name(option),
                                     values.front(), value));
    values.push_back(value);
  }

  void give_positional(const std::string& value) {
    require(place_ < places_.size(), fmt::format("'{}' is one argument too many", value));
    give(*places_[place_], value);
    if (places_[place_]->count == Option::Count::one) ++place_;
  }

  /// The option's value is the next word, unless that is an option: a value that begins with two
  /// hyphens is written with '='.
  void give_next(const Option& option, const std::vector<std::string>& words, std::size_t& i) {
    if (option.type == Option::Type::flag) return give(option, "true");
    require(i + 1 < words.size() && !words[i + 1].starts_with("--"),
            fmt::format("{} needs a value: {}", display_name(option), wanted(option)));
    give(option, words[++i]);
  }

  /// A letter is taken after two hyphens as well.
  const Option& named(const std::string& name) const {
    const auto at = std::ranges::find_if(table_.options(), [&](const Option& option) {
      return name.size() == 1 && option.letter == name[0];
    });
    return at == table_.options().end() ? table_.find(name) : *at;
  }

  void read_long(const std::vector<std::string>& words, std::size_t& i) {
    const std::size_t equals = words[i].find('=');
    const std::string name = words[i].substr(2, equals == std::string::npos ? equals : equals - 2);
    const Option& option = named(name);
    require(
        option.place == Option::Place::named,
        fmt::format("--{}: {} is given by its place, without a name", name, display_name(option)));
    if (equals == std::string::npos)
      give_next(option, words, i);
    else
      give(option, words[i].substr(equals + 1));
  }

  void read_short(const std::vector<std::string>& words, std::size_t& i) {
    for (const Option& option : table_.options())
      if (option.letter == words[i][1]) {
        require(words[i].size() == 2,
                fmt::format("'{}': write -{} and its value as two words", words[i], option.letter));
        return give_next(option, words, i);
      }
    throw InvalidInput(fmt::format("there is no option '{}' ('{} --help' lists them)",
                                   words[i], table_.command()));
  }

  const OptionTable& table_;
  std::vector<const Option*> places_;
  std::size_t place_ = 0;
  std::map<std::string, std::vector<std::string>> found_;
};

}  // namespace

OptionValues parse_arguments(const OptionTable& table, const std::vector<std::string>& words) {
  return ArgumentReader(table).read(words);
}

std::string value_name(const Option& option) {
  if (!option.metavar.empty()) return option.metavar;
  switch (option.type) {
    case Option::Type::flag: return "";
    case Option::Type::integer:
    case Option::Type::number: return "N";
    case Option::Type::length: return "LENGTH";
    case Option::Type::text: return "TEXT";
    case Option::Type::path: return "FILE";
    case Option::Type::choice: break;
  }
  std::string all;
  for (const std::string& choice : option.choices) all += (all.empty() ? "" : "|") + choice;
  return all;
}

std::string facts(const Option& option, HelpDetail detail) {
  const bool complete = detail == HelpDetail::complete;
  std::vector<std::string> all;
  if (!option.unit.empty()) all.push_back("in " + option.unit);
  if (const std::string range = range_text(option); complete && !range.empty()) all.push_back(range);
  if (complete && option.count == Option::Count::many && option.place == Option::Place::named)
    all.push_back("may be given several times");
  if (!option.default_value.empty())
    all.push_back("default " + option.default_value);
  else if (complete && option.required)
    all.push_back("required");
  return all.empty() ? "" : fmt::format(" [{}]", fmt::join(all, ", "));
}

std::string display_name(const Option& option) {
  if (option.place == Option::Place::named) return "--" + option.name;
  if (!option.metavar.empty()) return option.metavar;
  std::string name = option.name;
  for (char& c : name) c = (c >= 'a' && c <= 'z') ? char(c - 'a' + 'A') : c;
  return name;
}

std::string wrap_text(const std::string& text, int width, int indent) {
  std::string all;
  int column = indent;
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = text.find(' ', begin);
    if (end == std::string::npos) end = text.size();
    const int length = int(end - begin);
    if (column > indent && column + 1 + length > width) {
      all += "\n" + std::string(std::size_t(indent), ' ');
      column = indent;
    } else if (column > indent) {
      all += ' ';
      ++column;
    }
    all += text.substr(begin, end - begin);
    column += length;
    begin = end + 1;
  }
  return all;
}

namespace {

constexpr int help_width = 80;
constexpr int help_column = 28;

std::string usage_line(const OptionTable& table) {
  std::string line = "usage: " + table.command();
  for (const Option& option : table.options())
    if (option.place == Option::Place::positional) {
      const std::string name =
          display_name(option) + (option.count == Option::Count::many ? "..." : "");
      line += option.required ? " " + name : " [" + name + "]";
    }
  for (const Option& option : table.options())
    if (option.place == Option::Place::named && option.required)
      line += fmt::format(" {} {}",
                          option.letter ? fmt::format("-{}", option.letter) : "--" + option.name,
                          value_name(option));
  return wrap_text(line + " [options]", help_width, 8);
}

std::string option_head(const Option& option) {
  if (option.place == Option::Place::positional) return "  " + display_name(option);
  std::string head =
      option.letter ? fmt::format("  -{}, --{}", option.letter, option.name) : "  --" + option.name;
  const std::string value = value_name(option);
  return value.empty() ? head : head + " " + value;
}

std::string option_entry(const Option& option, HelpDetail detail) {
  std::string head = option_head(option);
  if (int(head.size()) + 2 > help_column)
    head += "\n" + std::string(help_column, ' ');
  else
    head.resize(help_column, ' ');
  std::string words = option.help + facts(option, detail);
  if (detail == HelpDetail::complete && !option.details.empty()) words += ". " + option.details;
  return head + wrap_text(words, help_width, help_column) + "\n";
}

}  // namespace

std::string help_text(const OptionTable& table, HelpDetail detail) {
  std::string text = usage_line(table) + "\n\n" + wrap_text(table.summary(), help_width, 0) + "\n";
  std::vector<std::string> groups;
  for (const Option& option : table.options())
    if (std::ranges::count(groups, option.group) == 0) groups.push_back(option.group);
  for (const std::string& group : groups) {
    if (detail == HelpDetail::brief && group == "Running") continue;
    text += "\n" + (group.empty() ? "" : group + ":\n");
    for (const Option& option : table.options())
      if (option.group == group) text += option_entry(option, detail);
  }
  if (!table.examples().empty()) text += "\nExamples:\n";
  for (const auto& [words, use] : table.examples())
    text += fmt::format("  {} {}\n      {}\n", table.command(), words, wrap_text(use, help_width, 6));
  if (detail == HelpDetail::brief)
    text += fmt::format("\n'{} --help' says all there is to know.\n", table.command());
  return text;
}

}  // namespace mq
