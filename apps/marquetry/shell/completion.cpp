#include "shell/completion.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/option_words.h"

namespace mq::app {
namespace {

/// `text` in single quotes, as bash and zsh read it.
std::string single_quoted(const std::string& text) {
  std::string all = "'";
  for (const char c : text)
    if (c == '\'')
      all += "'\\''";
    else
      all += c;
  return all + "'";
}

/// With a backslash before each of `signs`.
std::string escaped(const std::string& text, const std::string& signs) {
  std::string all;
  for (const char c : text) {
    if (signs.find(c) != std::string::npos) all += '\\';
    all += c;
  }
  return all;
}

bool is_named(const Option& option) { return option.place == Option::Place::named; }

/// "-o|--output": how the option may be written before its value.
std::string spellings(const Option& option, const std::string& between) {
  return (option.letter ? fmt::format("-{}{}", option.letter, between) : "") + "--" + option.name;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " ") + word;
  return all;
}

std::string verb_names(const std::vector<Verb>& verbs) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs) names.push_back(verb.table.verb());
  return joined(names);
}

// bash

/// What follows an option: choices, a file's name (which bash completes itself), or nothing known.
std::string bash_value(const Option& option) {
  if (option.type == Option::Type::choice)
    return fmt::format("words={}", single_quoted(joined(option.choices)));
  return option.type == Option::Type::path ? "return" : "compopt +o default; return";
}

std::string bash_verb(const OptionTable& table) {
  std::string text = fmt::format("    {})\n      case $before in\n", table.verb());
  std::vector<std::string> names = {"--help"};
  for (const Option& option : table.options()) {
    if (!is_named(option)) continue;
    names.push_back("--" + option.name);
    if (option.letter) names.push_back(fmt::format("-{}", option.letter));
    if (option.type != Option::Type::flag)
      text += fmt::format("        {}) {} ;;\n", spellings(option, "|"), bash_value(option));
  }
  return text + fmt::format("        *) [[ $word == -* ]] && words={} ;;\n      esac ;;\n",
                            single_quoted(joined(names)));
}

std::string bash_script(const std::vector<Verb>& verbs) {
  std::string text = R"(# bash completion of marquetry, made by 'marquetry --completion bash'
_marquetry() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=
  COMPREPLY=()
  # --name=value comes as three words.
  if [[ $word == = ]]; then
    word=
  elif [[ $before == = ]]; then
    before=${COMP_WORDS[COMP_CWORD-2]}
  fi
  if ((COMP_CWORD == 1)); then
    compopt +o default
)";
  text += fmt::format("    COMPREPLY=($(compgen -W {} -- \"$word\"))\n    return\n  fi\n",
                      single_quoted(verb_names(verbs) + " --help --version"));
  text += "  case ${COMP_WORDS[1]} in\n";
  for (const Verb& verb : verbs) text += bash_verb(verb.table);
  return text +
         "  esac\n  [[ $words ]] && COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n}\n"
         "complete -o default -F _marquetry marquetry\n";
}

// zsh

std::string zsh_option(const Option& option) {
  const std::string repeated = option.count == Option::Count::many ? "*" : "";
  std::string action;
  if (option.type != Option::Type::flag) {
    action = ":" + escaped(value_name(option), "\\:") + ":";
    if (option.type == Option::Type::choice) action += "(" + joined(option.choices) + ")";
    if (option.type == Option::Type::path) action += "_files";
  }
  const std::string about = "[" + escaped(option.help, "\\[]:") + "]" + action;
  if (!option.letter) return single_quoted(repeated + "--" + option.name + about);
  const std::string exclusive =
      repeated.empty() ? fmt::format("({})", spellings(option, " ")) : repeated;
  return single_quoted(exclusive) + "{" + spellings(option, ",") + "}" + single_quoted(about);
}

std::string zsh_script(const std::vector<Verb>& verbs) {
  std::string text =
      "#compdef marquetry\n# zsh completion of marquetry, made by 'marquetry --completion zsh'\n"
      "_marquetry() {\n  local -a verbs=(\n";
  for (const Verb& verb : verbs)
    text += "    " + single_quoted(verb.table.verb() + ":" + escaped(verb.table.summary(), "\\:")) + "\n";
  text +=
      "  )\n  if ((CURRENT == 2)); then\n    _describe verb verbs\n    return\n  fi\n"
      "  local verb=$words[2]\n  shift words\n  ((CURRENT--))\n  case $verb in\n";
  for (const Verb& verb : verbs) {
    text += fmt::format("    {})\n      _arguments \\\n", verb.table.verb());
    for (const Option& option : verb.table.options())
      if (is_named(option)) text += "        " + zsh_option(option) + " \\\n";
    text += "        '--help[all there is to know]' '*:file:_files' ;;\n";
  }
  return text + "  esac\n}\nif [[ $funcstack[1] == _marquetry ]]; then\n  _marquetry \"$@\"\nelse\n"
                "  compdef _marquetry marquetry\nfi\n";
}

// fish

/// `text` in single quotes, as fish reads it.
std::string fish_quoted(const std::string& text) { return "'" + escaped(text, "\\'") + "'"; }

std::string fish_option(const std::string& verb, const Option& option) {
  std::string line = fmt::format("complete -c marquetry -n '__marquetry_verb {}' -l {}", verb, option.name);
  if (option.letter) line += fmt::format(" -s {}", option.letter);
  if (option.type == Option::Type::choice)
    line += " -x -a " + fish_quoted(joined(option.choices));
  else if (option.type == Option::Type::path)
    line += " -r -F";
  else if (option.type != Option::Type::flag)
    line += " -x";
  return line + " -d " + fish_quoted(option.help) + "\n";
}

std::string fish_script(const std::vector<Verb>& verbs) {
  std::string text = R"(# fish completion of marquetry, made by 'marquetry --completion fish'
function __marquetry_verb
  set -l words (commandline -opc)
  test (count $words) -ge 2; and test $words[2] = $argv[1]
end
function __marquetry_no_verb
  test (count (commandline -opc)) -lt 2
end
complete -c marquetry -n __marquetry_no_verb -f -l help -d 'list the verbs'
complete -c marquetry -n __marquetry_no_verb -f -l version -d 'print the version'
)";
  for (const Verb& verb : verbs)
    text += fmt::format("complete -c marquetry -n __marquetry_no_verb -f -a {} -d {}\n", verb.table.verb(),
                        fish_quoted(verb.table.summary()));
  for (const Verb& verb : verbs)
    for (const Option& option : verb.table.options())
      if (is_named(option)) text += fish_option(verb.table.verb(), option);
  return text;
}

}  // namespace

std::string completion_script(const std::string& shell, const std::vector<Verb>& verbs) {
  if (shell == "bash") return bash_script(verbs);
  if (shell == "zsh") return zsh_script(verbs);
  if (shell == "fish") return fish_script(verbs);
  throw InvalidInput(fmt::format("--completion: found '{}', wanted bash, zsh or fish", shell));
}

}  // namespace mq::app
