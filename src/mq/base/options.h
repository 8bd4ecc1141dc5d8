#pragma once
/// The option table: each option of a verb is written down once, and the command line, help, the
/// JSON report, configuration files, documentation and a viewer's sliders are made from it.
///
///     OptionTable table("filter", "Smooth or sharpen a texture on its surface.");
///     table.add({.name = "mesh", .place = Option::Place::positional, .type = Option::Type::path,
///                .required = true, .help = "the model"});
///     table.add({.name = "beta", .type = Option::Type::number, .least = 0, .most = 100,
///                .help = "factor on the gradients"});
///     const OptionValues values = parse_arguments(table, {"bust.obj", "--beta", "3"});
///     values.number("beta");  // 3
///
/// Everything a user can get wrong (an unknown name, text for a number, a value out of range,
/// options that contradict each other) is an `InvalidInput` that names the option, the value found
/// and what was wanted.

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace mq {

/// One row of the table.
struct Option {
  enum class Type {
    flag,     ///< given or not
    integer,  ///< a whole number
    number,   ///< a finite number
    length,   ///< a distance on a surface: 0.02, 1% or 8tx (`parse_length`)
    choice,   ///< one of `choices`
    text,     ///< anything `accepts` accepts
    path      ///< a file or a folder
  };
  enum class Place {
    named,      ///< --name VALUE
    positional  ///< VALUE, in the order of the table
  };
  enum class Count { one, many };
  enum class Scope {
    result,  ///< changes what is computed: recorded, repeated from a configuration file
    run      ///< changes only how the run is shown or guarded: neither
  };

  std::string name;             ///< as typed after --, words joined by hyphens
  char letter = 0;              ///< a short form, -o (or --o); 0: none
  Place place = Place::named;
  Type type = Type::flag;
  Count count = Count::one;     ///< many: given several times; a positional one takes the rest
  std::string default_value = {};  ///< as a user would type it; empty: none
  bool required = false;
  std::string unit = {};        ///< of a number, for help and sliders; one in % may be typed with the sign
  double least = -std::numeric_limits<double>::infinity();  ///< of a number, inclusive
  double most = std::numeric_limits<double>::infinity();    ///< of a number, inclusive
  bool infinite = false;        ///< a number may also be inf
  std::vector<std::string> choices = {};
  std::function<bool(const std::string&)> accepts =
      {};                       ///< of a text, else any but ""; of a length
  std::string wanted = {};      ///< what `accepts` asks for, in words
  std::string metavar = {};     ///< what help calls the value; by default after the type
  std::string group = {};       ///< heading it stands under in the complete help
  std::string help = {};        ///< one line, without a full stop
  std::string details = {};     ///< what else there is to know, in sentences
  Scope scope = Scope::result;
};

/// The options of one verb, in the order help lists them.
class OptionTable {
 public:
  OptionTable(std::string verb, std::string summary);

  OptionTable& add(Option option);
  /// At most one of these may be given.
  OptionTable& exclusive(std::vector<std::string> names);
  /// A command that a user may copy, without "marquetry VERB", and what it is for, without a full stop.
  OptionTable& example(std::string words, std::string use);

  /// What to say of an option of that name that there is not, but users look for here: where to find it.
  OptionTable& elsewhere(std::string name, std::string where);

  /// The program whose verb it is, "marquetry" unless said otherwise.
  OptionTable& of_program(std::string name);

  /// What an option of this name has by default, in place of its own, when it is added from now on.
  OptionTable& with_default(std::string name, std::string value);

  const std::string& verb() const { return verb_; }
  const std::string& program() const { return program_; }
  std::string command() const { return program_ + " " + verb_; }  ///< as users type it
  const std::string& summary() const { return summary_; }  ///< one sentence
  const std::vector<Option>& options() const { return options_; }
  const std::vector<std::vector<std::string>>& exclusives() const { return exclusives_; }
  const std::vector<std::pair<std::string, std::string>>& examples() const { return examples_; }

  /// The option of this name. Throws `InvalidInput` with where it is found, or the nearest name, when there is none.
  const Option& find(const std::string& name) const;

 private:
  std::string program_ = "marquetry";
  std::string verb_;
  std::string summary_;
  std::vector<Option> options_;
  std::vector<std::vector<std::string>> exclusives_;
  std::vector<std::pair<std::string, std::string>> examples_;  ///< words, use
  std::map<std::string, std::string> elsewhere_, defaults_;
};

/// The values of one run: those given, else the defaults. Reading an option that has no value, or
/// one that is of another type, is an error of the program (`std::logic_error`).
class OptionValues {
 public:
  /// All at their defaults.
  explicit OptionValues(OptionTable table);

  /// Gives an option its value or values (a flag: "true" or "false"), checked against its row.
  void set(const std::string& name, const std::vector<std::string>& values);

  /// As if it had not been given.
  void reset(const std::string& name);

  bool given(const std::string& name) const;  ///< by the user, not by default
  bool has(const std::string& name) const;    ///< given, or a default stands (see `effective`)

  bool flag(const std::string& name) const;
  std::int64_t integer(const std::string& name) const;
  double number(const std::string& name) const;
  std::string text(const std::string& name) const;  ///< of any type, as typed
  std::vector<std::string> texts(const std::string& name) const;

  /// As typed, given or default; empty where neither exists, and where another option of the same
  /// exclusive group was given, so that its default does not stand.
  std::vector<std::string> effective(const std::string& name) const;

  /// Throws `InvalidInput` when a required option is missing or exclusive ones are given together.
  void check() const;

  const OptionTable& table() const { return table_; }

 private:
  const std::string& single(const std::string& name) const;

  OptionTable table_;
  std::map<std::string, std::vector<std::string>> given_;
};

/// Reads the words after the verb: `--name value`, `--name=value`, `-o value`, positional values,
/// and `--` before positional values that begin with a hyphen. Does not `check`, so that a
/// configuration file can still give what is missing.
OptionValues parse_arguments(const OptionTable& table, const std::vector<std::string>& words);

/// How `--name` is written in messages: "--beta", or "MESH" for a positional option.
std::string display_name(const Option& option);

/// The help page, 80 columns. Brief: usage and one line with its unit and default for each option outside the group
/// "Running"; complete: all groups with details and ranges. Examples come last.
enum class HelpDetail { brief, complete };
std::string help_text(const OptionTable& table, HelpDetail detail);

/// `text` broken into lines of at most `width` columns (a word is never broken), all but the first
/// indented by `indent` spaces. No newline at the end.
std::string wrap_text(const std::string& text, int width, int indent);

/// The candidate nearest to `word` by edit distance, or empty when none is near enough to be meant.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

/// ", did you mean 'beta'?" or nothing: the end of a message about an unknown word.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace mq
