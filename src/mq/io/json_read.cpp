// The parser says at which byte it stopped and in its own words why: "unexpected X; expected Y".
// Where a value stands is found only once it is to be refused, by walking over the text again.

#include "mq/io/json_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/options.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

using Json = nlohmann::json;

/// Where the text or word begins that ends at a byte.
std::size_t token_begin(std::string_view text, std::size_t at) {
  if (at == 0 || at >= text.size()) return at;
  if (text[at] == '"') {
    const std::size_t opening = text.rfind('"', at - 1);
    return opening == text.npos ? at : opening;
  }
  constexpr std::string_view ends = "{}[],:\" \t\r\n";
  if (ends.find(text[at]) != ends.npos) return at;
  while (at > 0 && ends.find(text[at - 1]) == ends.npos) --at;
  return at;
}

/// The byte at which the parser stopped. Of a number too large for it, it says which, not where.
std::size_t stopped_at(std::string_view text, const nlohmann::detail::exception& error) {
  if (const auto* parse = dynamic_cast<const nlohmann::detail::parse_error*>(&error)) {
    const std::size_t at = parse->byte > 0 ? parse->byte - 1 : 0;
    const bool token = std::string_view(error.what()).find(" literal") != std::string_view::npos;
    return token ? token_begin(text, at) : at;
  }
  const std::string_view reason = error.what();
  const std::size_t begin = reason.find('\''), end = reason.rfind('\'');
  if (begin == reason.npos || end <= begin) return 0;
  const std::size_t at = text.find(reason.substr(begin + 1, end - begin - 1));
  return at == text.npos ? 0 : at;
}

void replace(std::string& text, std::string_view what, std::string_view by) {
  if (const std::size_t at = text.find(what); at != text.npos) text.replace(at, what.size(), by);
}

/// What other programs write there for numbers that JSON has no words for; else nothing.
std::string no_number_at(std::string_view text, std::size_t at) {
  for (const std::string_view word : {"NaN", "nan", "Infinity", "-Infinity", "inf", "-inf"})
    if (text.substr(std::min(at, text.size())).starts_with(word)) return std::string(word);
  return {};
}

/// What the parser says went wrong, without its numbers of errors and places.
std::string reason_of(const nlohmann::detail::exception& error) {
  std::string reason = error.what();
  if (reason.find("UTF-8") != reason.npos) return "holds bytes that are not UTF-8: save it as UTF-8";
  if (reason.find("overflow") != reason.npos) return "found a number too large to be read";
  if (const std::size_t at = reason.find(" - "); at != reason.npos) reason.erase(0, at + 3);
  if (const std::size_t at = reason.find("; last read:"); at != reason.npos) {
    const std::size_t rest = reason.find("; expected", at);
    reason.erase(at, rest == reason.npos ? rest : rest - at);
  }
  if (reason.find("unexpected ") == reason.npos) reason = "found " + reason;
  replace(reason, "unexpected ", "found ");
  replace(reason, "end of input", "the end of the file");
  replace(reason, "; expected ", ", wanted ");
  return "not JSON from here on: " + reason;
}

std::string shown_json(const Json& value) {
  switch (value.type()) {
    case Json::value_t::object: return "an object";
    case Json::value_t::array: return fmt::format("a list of {}", value.size());
    case Json::value_t::string: return shown(value.get<std::string>());
    default: return value.dump();
  }
}

std::string path_of(const std::vector<JsonStep>& steps) {
  std::string path;
  for (const JsonStep& step : steps)
    if (const auto* name = std::get_if<std::string>(&step))
      path += (path.empty() ? "" : ".") + *name;
    else
      path += fmt::format("[{}]", std::get<std::size_t>(step));
  return path;
}

bool is_finite_number(const Json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

std::vector<JsonStep> joined(std::vector<JsonStep> steps, const std::vector<JsonStep>& more) {
  steps.insert(steps.end(), more.begin(), more.end());
  return steps;
}

}  // namespace

std::string text_place(const std::string& file, std::string_view text, std::size_t offset) {
  offset = std::min(offset, text.size());
  std::size_t begin = offset;
  while (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r') --begin;
  int column = 1;
  for (std::size_t i = begin; i < offset; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) ++column;
  return fmt::format("{}, line {}, column {}", file, Scanner::line(text, offset), column);
}

std::string json_place(const std::string& file, std::string_view text,
                       const std::vector<JsonStep>& steps) {
  std::vector<JsonStep> there = steps;
  std::optional<JsonPlace> place = find_json(text, there);
  while (!place && !there.empty()) {
    there.pop_back();
    place = find_json(text, there);
  }
  return text_place(file, text, place ? place->begin : 0);
}

void refuse_deep_json(const std::string& file, std::string_view text) {
  if (const auto at = too_deep_json(text))
    throw IoError(fmt::format("{}: arrays and objects lie in each other {} deep, more than any that is "
                              "known: check that it is what it should be",
                              text_place(file, text, *at), most_json_levels));
}

void refuse_json(const std::string& file, std::string_view text, const std::string& wanted,
                 const nlohmann::detail::exception& error) {
  std::size_t at = stopped_at(text, error);
  if (at > 0 && at <= text.size() && text[at - 1] == '-') --at;
  const std::string word = no_number_at(text, at), place = text_place(file, text, at);
  if (!word.empty())
    throw IoError(fmt::format("{}: found {}, which stands for no number and is not JSON: wanted a number; whatever wrote "
                              "the file failed there",
                              place, word));
  throw IoError(fmt::format("{}: {} (wanted {})", place, reason_of(error), wanted));
}

JsonObject::JsonObject(const JsonFile& file, const std::string& wanted)
    : JsonObject(file, file.document, {}) {
  if (!value_->is_object()) refuse({}, *value_, wanted);
}

JsonObject::JsonObject(const JsonFile& file, const Json& value, std::vector<JsonStep> steps)
    : file_(&file), value_(&value), steps_(std::move(steps)) {}

std::string JsonObject::place() const {
  const std::string path = path_of(steps_);
  return json_place(file_->file, file_->text, steps_) + (path.empty() ? "" : ": " + path);
}

void JsonObject::require_only(const std::vector<std::string>& names) const {
  for (const auto& [name, value] : value_->items()) {
    if (std::ranges::find(names, name) != names.end()) continue;
    const std::string near = did_you_mean(name, names);
    throw IoError(fmt::format("{}: found \"{}\"{} wanted one of {}",
                              json_place(file_->file, file_->text, joined(steps_, {name})), name,
                              near.empty() ? ":" : near, fmt::join(names, ", ")));
  }
}

const Json& JsonObject::member(const std::string& name, const std::string& wanted) const {
  const auto found = value_->find(name);
  if (found == value_->end())
    throw IoError(fmt::format("{}: found no \"{}\", wanted {} there", place(), name, wanted));
  return *found;
}

void JsonObject::refuse(const std::vector<JsonStep>& below, const Json& found,
                        const std::string& wanted) const {
  const std::vector<JsonStep> steps = joined(steps_, below);
  const std::string path = path_of(steps);
  throw IoError(fmt::format("{}: {}found {}, wanted {}", json_place(file_->file, file_->text, steps),
                            path.empty() ? "" : path + ": ", shown_json(found), wanted));
}

double JsonObject::number(const std::string& name) const {
  const Json& value = member(name, "a number");
  if (!is_finite_number(value)) refuse({name}, value, "a number");
  return value.get<double>();
}

double JsonObject::number(const std::string& name, double otherwise) const {
  return has(name) ? number(name) : otherwise;
}

int JsonObject::whole(const std::string& name, int least, int most) const {
  const std::string wanted = fmt::format("a whole number from {} to {}", least, most);
  const Json& value = member(name, wanted);
  const double number = is_finite_number(value) ? value.get<double>() : std::nan("");
  if (!(number >= least && number <= most && number == std::floor(number)))
    refuse({name}, value, wanted);
  return int(number);
}

std::string JsonObject::text(const std::string& name) const {
  const Json& value = member(name, "a text");
  if (!value.is_string()) refuse({name}, value, "a text");
  return value.get<std::string>();
}

bool JsonObject::truth(const std::string& name) const {
  const Json& value = member(name, "true or false");
  if (!value.is_boolean()) refuse({name}, value, "true or false");
  return value.get<bool>();
}

std::vector<double> JsonObject::numbers(const std::string& name, std::size_t count) const {
  const std::string wanted = fmt::format("{} numbers", count);
  const Json& value = member(name, wanted);
  if (!value.is_array() || value.size() != count) refuse({name}, value, wanted);
  std::vector<double> found;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_finite_number(value[i])) refuse({name, i}, value[i], "a number");
    found.push_back(value[i].get<double>());
  }
  return found;
}

std::vector<double> JsonObject::rows(const std::string& name, std::size_t count,
                                     std::size_t columns) const {
  const std::string wanted = fmt::format("{} rows of {} numbers", count, columns);
  const Json& value = member(name, wanted);
  if (!value.is_array() || value.size() != count) refuse({name}, value, wanted);
  return rows_of(name, value, columns);
}

std::vector<double> JsonObject::rows(const std::string& name, std::size_t columns) const {
  const std::string wanted = fmt::format("a list of rows of {} numbers", columns);
  const Json& value = member(name, wanted);
  if (!value.is_array()) refuse({name}, value, wanted);
  return rows_of(name, value, columns);
}

std::vector<double> JsonObject::rows_of(const std::string& name, const Json& value, std::size_t columns) const {
  std::vector<double> found;
  for (std::size_t r = 0; r < value.size(); ++r) {
    if (!value[r].is_array() || value[r].size() != columns)
      refuse({name, r}, value[r], fmt::format("a row of {} numbers", columns));
    for (std::size_t c = 0; c < columns; ++c) {
      if (!is_finite_number(value[r][c])) refuse({name, r, c}, value[r][c], "a number");
      found.push_back(value[r][c].get<double>());
    }
  }
  return found;
}

std::vector<JsonObject> JsonObject::objects(const std::string& name) const {
  const Json& value = member(name, "a list of objects");
  if (!value.is_array()) refuse({name}, value, "a list of objects");
  std::vector<JsonObject> found;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value[i].is_object()) refuse({name, i}, value[i], "an object");
    found.push_back(JsonObject(*file_, value[i], joined(steps_, {name, i})));
  }
  return found;
}

}  // namespace mq
