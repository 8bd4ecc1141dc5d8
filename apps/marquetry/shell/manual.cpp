#include "shell/manual.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/option_words.h"
#include "mq/version.h"

namespace mq::app {
namespace {

/// The code point that begins at text[i]; i is moved behind it. Bytes that are not UTF-8 stand for
/// themselves.
unsigned code_point(const std::string& text, std::size_t& i) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  const unsigned first = byte(i++);
  const int more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC0 ? 1 : 0;
  if (more == 0 || i + std::size_t(more) > text.size()) return first;
  unsigned point = first & (0x3FU >> more);
  for (int n = 0; n < more; ++n) point = point << 6 | (byte(i++) & 0x3FU);
  return point;
}

/// Text as roff prints it unchanged: signs with a meaning of their own escaped, all that is not ASCII by
/// its number, so that the page has no encoding.
std::string roff(const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < text.size();) {
    const unsigned point = code_point(text, i);
    switch (point) {
      case '\\': all += "\\e"; break;
      case '-': all += "\\-"; break;
      case '\'': all += "\\(aq"; break;
      case '`': all += "\\(ga"; break;
      case '^': all += "\\(ha"; break;
      case '~': all += "\\(ti"; break;
      case '"': all += "\\(dq"; break;
      default: all += point < 0x80 ? std::string(1, char(point)) : fmt::format("\\[u{:04X}]", point);
    }
  }
  return all.starts_with('.') ? "\\&" + all : all;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string title(const std::string& name) {
  std::string upper = name;
  for (char& c : upper) c = (c >= 'a' && c <= 'z') ? char(c - 'a' + 'A') : c;
  return fmt::format(".TH \"{}\" 1 \"\" \"marquetry {}\" \"Marquetry\"\n", roff(upper), version);
}

std::string section(const std::string& name) { return ".SH " + name + "\n"; }

/// A summary as a line of NAME has it: without the full stop.
std::string brief(std::string summary) {
  if (summary.ends_with('.')) summary.pop_back();
  return summary;
}

std::string head(const Option& option) {
  if (option.place == Option::Place::positional)
    return italic(display_name(option)) + (option.count == Option::Count::many ? " ..." : "");
  std::string text =
      (option.letter ? bold(fmt::format("-{}", option.letter)) + ", " : "") + bold("--" + option.name);
  const std::string value = value_name(option);
  return value.empty() ? text : text + " " + italic(value);
}

std::string entry(const Option& option) {
  return ".TP\n" + head(option) + "\n" +
         roff(option.help + facts(option) + (option.details.empty() ? "" : ". " + option.details)) +
         "\n";
}

std::string synopsis(const OptionTable& table) {
  std::string line = bold("marquetry " + table.verb());
  for (const Option& option : table.options())
    if (option.place == Option::Place::positional)
      line += option.required ? " " + head(option) : " [" + head(option) + "]";
  for (const Option& option : table.options())
    if (option.place == Option::Place::named && option.required)
      line += " " + bold(option.letter ? fmt::format("-{}", option.letter) : "--" + option.name) + " " +
              italic(value_name(option));
  return line + " [options]\n";
}

const std::string exit_status =
    ".TP\n0\ndone\n.TP\n1\n\\fBcheck\\fR found defects\n.TP\n2\nan option, an input or the work itself was "
    "at fault; the message says what was found and what to do\n.TP\n130\ncancelled\n";

}  // namespace

std::string manual_page(const std::vector<Verb>& verbs) {
  std::string page = title("marquetry") + section("NAME") +
                     roff("marquetry - signal processing on textured triangle meshes") + "\n" +
                     section("SYNOPSIS") + bold("marquetry") + " " + italic("VERB") + " " +
                     italic("INPUT") + "... [" + bold("-o") + " " + italic("OUTPUT") +
                     "] [options]\n.br\n" + bold("marquetry") + " " + italic("VERB") + " " +
                     bold("--help") + "\n" + section("VERBS");
  for (const Verb& verb : verbs)
    page += ".TP\n" + bold(verb.table.verb()) + "\n" + roff(verb.table.summary()) + " See " +
            bold("marquetry-" + verb.table.verb()) + "(1).\n";
  page += section("\"EXIT STATUS\"") + exit_status;
  page += section("ENVIRONMENT") + ".TP\n" + bold("NO_COLOR") +
          "\nno colours on the terminal\n.TP\n" + bold("MARQUETRY_INSTRUCTIONS") + "\n" +
          roff("x86-64, x86-64-v3 or x86-64-v4: the form of the kernels to use in place of the best that "
               "the machine has, to compare machines to the last bit") +
          "\n" + section("\"SEE ALSO\"");
  for (std::size_t i = 0; i < verbs.size(); ++i)
    page += bold("marquetry-" + verbs[i].table.verb()) + "(1)" +
            (i + 1 < verbs.size() ? "," : "") + "\n";
  return page;
}

std::string manual_page(const OptionTable& table) {
  const std::string name = "marquetry-" + table.verb();
  std::string page = title(name) + section("NAME") + roff(name + " - " + brief(table.summary())) +
                     "\n" + section("SYNOPSIS") + synopsis(table) + section("DESCRIPTION") +
                     roff(table.summary()) + "\n" + section("OPTIONS");
  std::vector<std::string> groups;
  for (const Option& option : table.options())
    if (std::ranges::count(groups, option.group) == 0) groups.push_back(option.group);
  for (const std::string& group : groups) {
    if (!group.empty()) page += ".SS \"" + roff(group) + "\"\n";
    for (const Option& option : table.options())
      if (option.group == group) page += entry(option);
  }
  if (!table.examples().empty()) page += section("EXAMPLES");
  for (const auto& [words, use] : table.examples())
    page += ".TP\n" + bold("marquetry " + table.verb() + " " + words) + "\n" + roff(use) + "\n";
  return page + section("\"EXIT STATUS\"") + exit_status + section("\"SEE ALSO\"") +
         bold("marquetry") + "(1)\n";
}

}  // namespace mq::app
