// The commands of scripts, and their words.
#include "script_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/options.h"
#include "shell/arguments.h"

namespace mq::view {
namespace {

struct Command {
  const char* name;
  int least, most;  ///< words after it
  const char* use;
};

constexpr int any = 1000;

constexpr Command commands[] = {
    {"view", 1, 1, "view NAME or view AZIMUTH,ELEVATION"},
    {"home", 0, 0, "home"},
    {"up", 1, 1, "up y|z|x|-x|-y|-z"},
    {"look-at", 2, 2, "look-at X,Y,Z EXTENT"},
    {"turn", 2, 2, "turn RIGHT UP (degrees)"},
    {"zoom", 1, 1, "zoom FACTOR"},
    {"atlas", 1, 3, "atlas home, atlas TEXTURE or atlas TEXTURE COLUMN,ROW ZOOM"},
    {"show", 1, 1, "show WHAT"},
    {"overlay", 2, 2, "overlay seams|wires|charts on|off"},
    {"light", 1, 1, "light on|off"},
    {"exposure", 1, 1, "exposure STOPS"},
    {"channel", 1, 1, "channel NUMBER"},
    {"range", 1, 1, "range LOW,HIGH or range whole"},
    {"map", 1, 1, "map sequential|diverging"},
    {"isolines", 1, 1, "isolines COUNT"},
    {"wipe", 1, 1, "wipe FRACTION or wipe off"},
    {"hover", 3, 3, "hover surface|atlas X Y"},
    {"click", 3, 3, "click surface|atlas X Y"},
    {"drag", 5, any, "drag surface|atlas X Y X Y ..."},
    {"turn-by-mouse", 5, 5, "turn-by-mouse surface X Y X Y"},
    {"wheel", 4, 4, "wheel surface|atlas X Y STEPS"},
    {"tool", 1, 1, "tool NAME"},
    {"frame", 1, 1, "frame NUMBER"},
    {"play", 1, 1, "play COUNT"},
    {"open", 1, any, "open FILE ..."},
    {"drop", 1, any, "drop FILE ..."},
    {"answer", 1, 1, "answer yes|no|save|keep"},
    {"ask", 0, 0, "ask"},
    {"keep", 0, 0, "keep"},
    {"sample", 1, 1, "sample NAME"},
    {"recent", 1, 1, "recent NUMBER"},
    {"task", 1, 1, "task NAME"},
    {"key", 1, 1, "key NAME"},
    {"theme", 1, 1, "theme dark|light"},
    {"picture", 2, 3, "picture FILE surface|atlas [TIMES]"},
    {"history", 1, 1, "history NUMBER"},
    {"next-difference", 0, 0, "next-difference"},
    {"close-model", 0, 0, "close-model"},
    {"stop", 0, 0, "stop"},
    {"close", 0, 0, "close"},
    {"wait", 0, 0, "wait"},
    {"frames", 1, 1, "frames COUNT"},
    {"screenshot", 1, 2, "screenshot FILE [surface|atlas]"},
    {"quit", 0, 0, "quit"},
    // What tools do.
    {"set", 2, any, "set OPTION VALUE"},
    {"brush", 1, 1, "brush sharpen|smooth|erase"},
    {"size", 1, 1, "size LENGTH"},
    {"strength", 1, 1, "strength NUMBER"},
    {"hardness", 1, 1, "hardness NUMBER"},
    {"run", 0, 0, "run"},
    {"stroke", 1, any, "stroke X,Y,Z X,Y,Z ..."},
    {"fill", 1, 1, "fill everywhere|nowhere"},
    {"source", 1, 1, "source X,Y,Z"},
    {"with", 1, any, "with FILE ..."},
    {"photograph", 1, 1, "photograph NUMBER or photograph best"},
    {"region", 1, 1, "region brush|chart"},
    {"save-labels", 1, 1, "save-labels FILE"},
    {"stage", 1, 1, "stage NUMBER or stage last"},
    {"undo", 0, 0, "undo"},
    {"redo", 0, 0, "redo"},
    {"save-texture", 1, 2, "save-texture FILE [behind]"},
    {"save-mask", 1, 1, "save-mask FILE"},
    {"save-strokes", 1, 1, "save-strokes FILE"},
    {"copy-command", 0, 1, "copy-command [FILE]"},
};

}  // namespace

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  bool quoted = false, inside = false;
  for (const char c : line) {
    if (c == '"') {
      if (!inside) words.emplace_back();
      quoted = !quoted, inside = true;
    } else if (!quoted && (c == ' ' || c == '\t' || c == '\r')) {
      inside = false;
    } else if (!quoted && !inside && c == '#') {
      break;
    } else {
      if (!inside) words.emplace_back();
      words.back() += c, inside = true;
    }
  }
  require(!quoted, "a quotation mark is missing");
  return words;
}

void check_command(const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const Command& command : commands) {
    names.emplace_back(command.name);
    if (words[0] != command.name) continue;
    const int count = int(words.size()) - 1;
    require(count >= command.least && count <= command.most,
            fmt::format("'{}' has {} words after it, wanted: {}", words[0], count, command.use));
    return;
  }
  throw InvalidInput(
      fmt::format("there is no command '{}'{}", words[0], did_you_mean(words[0], names)));
}

double number(const std::string& word, double least, double most) {
  const auto parsed = app::parse_numbers(word, 1);
  require(parsed && parsed->front() >= least && parsed->front() <= most,
          fmt::format("found '{}', wanted a number from {:g} to {:g}", word, least, most));
  return parsed->front();
}

int whole(const std::string& word, int least, int most) {
  const double value = number(word, least, most);
  require(value == std::floor(value), fmt::format("found '{}', wanted a whole number", word));
  return int(value);
}

std::vector<double> numbers(const std::string& word, std::size_t count, const char* wanted) {
  const auto parsed = app::parse_numbers(word, count);
  require(parsed.has_value(), fmt::format("found '{}', wanted {}", word, wanted));
  return *parsed;
}

int one_of(const std::string& word, const std::vector<std::string>& choices) {
  const auto found = std::ranges::find(choices, word);
  std::string list;
  for (const std::string& choice : choices) list += (list.empty() ? "" : ", ") + choice;
  require(found != choices.end(), fmt::format("found '{}', wanted one of {}", word, list));
  return int(found - choices.begin());
}

bool is_on(const std::string& word) { return one_of(word, {"off", "on"}) == 1; }

}  // namespace mq::view
