#include "mq/io/detail/json_text.h"

#include <nlohmann/json.hpp>

namespace mq {
namespace {

/// Walks over valid JSON without looking at more of it than it must.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {}

  std::optional<JsonPlace> find(std::span<const JsonStep> steps) {
    for (const JsonStep& step : steps) {
      skip_space();
      const bool found = step.index() == 0 ? enter_member(std::get<std::string>(step))
                                           : enter_item(std::get<std::size_t>(step));
      if (!found) return {};
    }
    skip_space();
    const std::size_t begin = at_;
    skip_value();
    return JsonPlace{begin, at_};
  }

 private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void skip_space() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != text_.npos) ++at_;
  }

  void skip_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_)
      if (text_[at_] == '\\') ++at_;
    ++at_;
  }

  void skip_value() {
    int depth = 0;
    do {
      const char c = peek();
      if (c == '"') {
        skip_string();
      } else {
        if (c == '{' || c == '[') ++depth;
        if (c == '}' || c == ']') --depth;
        const bool word = std::string_view("{}[],: \t\r\n").find(c) == text_.npos;
        ++at_;
        while (word && at_ < text_.size() &&
               std::string_view("{}[],: \t\r\n\"").find(text_[at_]) == text_.npos)
          ++at_;
      }
    } while (depth > 0 && at_ < text_.size());
  }

  /// Goes to the value of the last member with this name.
  bool enter_member(const std::string& name) {
    if (peek() != '{') return false;
    std::optional<std::size_t> found;
    for (++at_;;) {
      skip_space();
      if (peek() != '"') break;
      const std::size_t begin = at_;
      skip_string();
      const std::string_view key = text_.substr(begin, at_ - begin);
      skip_space();
      ++at_;  // the colon
      skip_space();
      if (nlohmann::json::parse(key) == name) found = at_;
      skip_value();
      skip_space();
      if (peek() != ',') break;
      ++at_;
    }
    if (found) at_ = *found;
    return found.has_value();
  }

  bool enter_item(std::size_t index) {
    if (peek() != '[') return false;
    ++at_;
    for (;; ++at_) {
      skip_space();
      if (peek() == ']' || at_ >= text_.size()) return false;
      if (index-- == 0) return true;
      skip_value();
      skip_space();
      if (peek() != ',') return false;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

std::optional<JsonPlace> find_json(std::string_view text, std::span<const JsonStep> steps) {
  return Walker(text).find(steps);
}

std::optional<std::size_t> too_deep_json(std::string_view text) {
  int level = 0;
  bool in_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (in_string && c == '\\')
      ++at;
    else if (c == '"')
      in_string = !in_string;
    else if (!in_string && (c == '[' || c == '{') && ++level > most_json_levels)
      return at;
    else if (!in_string && (c == ']' || c == '}'))
      --level;
  }
  return {};
}

std::string json_string(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mq
