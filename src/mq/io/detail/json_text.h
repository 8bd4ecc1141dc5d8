#pragma once
/// Where a value stands in the text of a JSON document, so that it can be replaced and nothing
/// else.

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace mq {

/// The place of a value in a text.
struct JsonPlace {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// A step to a value: a member's name or an item's index.
using JsonStep = std::variant<std::string, std::size_t>;

/// Where the value lies that `steps` lead to from the root. `text` must be valid JSON. Nothing when
/// there is no such value. Of members with one name the last counts, as it does for parsers.
std::optional<JsonPlace> find_json(std::string_view text, std::span<const JsonStep> steps);
inline std::optional<JsonPlace> find_json(std::string_view text,
                                          std::initializer_list<JsonStep> steps) {
  return find_json(text, std::span(steps.begin(), steps.size()));
}

/// How deep arrays and objects may lie in each other: what handles a document calls itself for each, and
/// no file that we know of has more than a dozen.
inline constexpr int most_json_levels = 256;

/// Where a text goes deeper than that; nothing: it does not. The text may be anything.
std::optional<std::size_t> too_deep_json(std::string_view text);

/// A string as JSON spells it, with its quotation marks.
std::string json_string(std::string_view text);

}  // namespace mq
