// A layer is a head, "#usda 1.0", metadata in parentheses, and prims:
//   def TYPE "NAME" ( metadata ) { properties and prims }
// A property is a line of words, of which the last is its name and the last but one its type, with a value behind
// "=" and metadata in parentheses where it has them. Comments are "#" and "//" to the end of a line, and "/* */".
#include "mq/io/detail/usd_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <type_traits>

#include "mq/base/error.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

constexpr std::string_view usda_head = "#usda 1.";
constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

bool is_number_part(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '+' ||
         c == '-';
}

/// Of a name, which may be that of a type, such as "float[]", or "xformOp:translate".
bool is_name_part(char c) {
  return is_number_part(c) || (c & 0x80) != 0 || c == '_' || c == ':' || c == '[' || c == ']';
}

/// Where text goes on: a cursor that knows what may stand between words.
class UsdCursor {
 public:
  UsdCursor(const UsdText& layer, std::string_view text) : layer_(layer), text_(text) {}

  bool at_end() const { return at_ >= text_.size(); }
  char peek() const { return at_end() ? '\0' : text_[at_]; }
  std::string_view here() const { return text_.substr(std::min(at_, text_.size())); }
  std::size_t offset() const { return at_; }
  std::string_view since(std::size_t begin) const { return text_.substr(begin, at_ - begin); }

  /// Inside of a line; a comment may go on in the next.
  void skip_blanks() {
    while (true) {
      const char c = peek();
      if (c == ' ' || c == '\t')
        ++at_;
      else if (!here().starts_with("/*") || !skip_comment())
        return;
    }
  }

  /// Blanks, ends of lines, comments, and what may stand between statements.
  void skip_space(std::string_view separators = "") {
    while (!at_end()) {
      const char c = text_[at_];
      if (skip_comment()) continue;
      if (c != ' ' && c != '\t' && c != '\n' && c != '\r' && separators.find(c) == separators.npos) return;
      ++at_;
    }
  }

  bool take(char c) {
    if (peek() != c || at_end()) return false;
    ++at_;
    return true;
  }

  std::string_view word(bool (*is_part)(char) = is_name_part) {
    const std::size_t begin = at_;
    while (!at_end() && is_part(text_[at_])) ++at_;
    return since(begin);
  }

  /// A value: a word, something between marks, or everything to the bracket that closes.
  std::string_view value() {
    const std::size_t begin = at_;
    std::string open;
    do {
      if (!open.empty()) skip_inside();
      if (at_end()) layer_.fail(text_.substr(begin), "what begins here has no end; the file may be cut short");
      const char c = text_[at_];
      if (c == '[' || c == '(' || c == '{') {
        open += c == '[' ? ']' : c == '(' ? ')' : '}';
        ++at_;
      } else if (c == ']' || c == ')' || c == '}') {
        if (open.empty() || open.back() != c) layer_.fail(here(), fmt::format("found '{}', wanted a value", c));
        open.pop_back();
        ++at_;
      } else if (c == '"' || c == '\'' || c == '@' || c == '<') {
        skip_marked();
      } else if (open.empty() && word().empty()) {
        layer_.fail(here(), fmt::format("found {}, wanted a value", shown(here().substr(0, 1))));
      }
    } while (!open.empty());
    return since(begin);
  }

 private:
  /// False where none begins here.
  bool skip_comment() {
    const char c = peek();
    if (c != '#' && c != '/') return false;
    if (c == '#' || here().starts_with("//")) {
      at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
      return true;
    }
    if (!here().starts_with("/*")) return false;
    const std::size_t end = text_.find("*/", at_ + 2);
    if (end == text_.npos)
      layer_.fail(here(), "the comment that begins here has no end, wanted '*/'; the file may be cut short");
    at_ = end + 2;
    return true;
  }

  /// Inside of brackets: to the next mark, past comments.
  void skip_inside() {
    constexpr std::string_view marks = "[](){}\"'@<#/";
    while (!at_end()) {
      at_ = std::min(text_.find_first_of(marks, at_), text_.size());
      if (skip_comment()) continue;
      if (peek() != '/') return;
      ++at_;
    }
  }

  /// Text, the name of a file or a path, between marks that are thrice where there are three.
  void skip_marked() {
    const std::size_t begin = at_;
    const char mark = text_[at_];
    const char closing = mark == '<' ? '>' : mark;
    const std::size_t length = mark != '<' && text_.substr(at_).starts_with(std::string(3, mark)) ? 3 : 1;
    const std::string end(length, closing);
    for (at_ += length; !at_end(); ++at_) {
      if (text_[at_] == '\\' && (mark != '@' || length == 3)) {
        ++at_;
      } else if (text_.substr(at_, length) == end) {
        at_ += length;
        return;
      } else if (length == 1 && text_[at_] == '\n') {
        break;
      }
    }
    layer_.fail(text_.substr(begin),
                fmt::format("what begins with {} has no end", shown(text_.substr(begin, length))));
  }

  const UsdText& layer_;
  std::string_view text_;
  std::size_t at_ = 0;
};

/// What a property is set to; nothing where a value is blocked.
std::string_view unless_blocked(std::string_view value) {
  return value == "None" || value == "AnimationBlock" ? std::string_view() : value;
}

class LayerParser {
 public:
  LayerParser(const UsdText& layer, std::string_view text) : layer_(layer), cursor_(layer, text) {}

  UsdPrim parse() {
    UsdPrim root;
    cursor_.skip_space();
    if (cursor_.peek() == '(') root.metadata = cursor_.value();
    parse_items(root, 0);
    if (!cursor_.at_end()) layer_.fail(cursor_.here(), "found '}' that closes nothing");
    return root;
  }

 private:
  using Known = std::map<std::string_view, std::size_t>;  // properties of a prim

  /// Properties and prims to the bracket that closes, or the end.
  void parse_items(UsdPrim& prim, int level) {
    Known known;
    while (true) {
      cursor_.skip_space(";");
      if (cursor_.at_end() || cursor_.peek() == '}') return;
      const std::string_view place = cursor_.here();
      const std::string_view first = cursor_.word();
      if (first.empty())
        layer_.fail(place, fmt::format("found {}, wanted a property or a prim", shown(place.substr(0, 1))));
      if (first == "def" || first == "over" || first == "class")
        parse_prim(prim.children.emplace_back(), first, level + 1);
      else if (first == "variantSet")
        skip_variants(prim);
      else
        parse_property(prim, known, first);
    }
  }

  void parse_prim(UsdPrim& prim, std::string_view specifier, int level) {
    if (level > most_usd_levels)
      layer_.fail(specifier, fmt::format("prims lie in each other more than {} deep", most_usd_levels));
    prim.specifier = specifier;
    cursor_.skip_space();
    prim.type = cursor_.word();
    cursor_.skip_space();
    if (cursor_.peek() != '"' && cursor_.peek() != '\'')
      layer_.fail(cursor_.here(),
                  fmt::format("found {}, wanted the name of a prim", shown(cursor_.here().substr(0, 20))));
    prim.name = usd_unquoted(cursor_.value());
    cursor_.skip_space();
    if (cursor_.peek() == '(') prim.metadata = cursor_.value();
    cursor_.skip_space();
    const std::string_view body = cursor_.here();
    if (!cursor_.take('{'))
      layer_.fail(body, fmt::format("found {}, wanted '{{', the properties of {}", shown(body.substr(0, 20)),
                                    shown(prim.name)));
    parse_items(prim, level);
    if (!cursor_.take('}'))
      layer_.fail(body, fmt::format("{} has no end; the file may be cut short", shown(prim.name)));
  }

  /// Variants are choices, and none of them is made here.
  void skip_variants(UsdPrim& prim) {
    prim.has_variants = true;
    cursor_.skip_space();
    cursor_.value();
    cursor_.skip_space();
    if (!cursor_.take('=')) layer_.fail(cursor_.here(), "a variantSet has no '='");
    cursor_.skip_space();
    cursor_.value();
  }

  void parse_property(UsdPrim& prim, Known& known, std::string_view first) {
    std::string_view before, last = first;
    for (cursor_.skip_blanks(); is_name_part(cursor_.peek()); cursor_.skip_blanks()) {
      before = last;
      last = cursor_.word();
    }
    if (before.empty()) layer_.fail(first, fmt::format("found {}, wanted a property or a prim", shown(first)));
    const bool sampled = last.ends_with(".timeSamples"), connected = last.ends_with(".connect");
    const bool splined = last.ends_with(".spline");
    const std::string_view name = sampled || connected || splined ? last.substr(0, last.rfind('.')) : last;
    // A value and time samples of one name are two lines.
    const auto [place, is_new] = known.try_emplace(name, prim.properties.size());
    UsdProperty& property = is_new ? prim.properties.emplace_back() : prim.properties[place->second];
    property.type = before;
    property.name = name;
    if (cursor_.take('=')) {
      cursor_.skip_space();
      const std::string_view value = cursor_.value();
      if (sampled)
        property.samples = samples(value);
      else if (splined)
        property.has_spline = true;
      else
        (connected ? property.connection : property.value) = unless_blocked(value);
    } else if (sampled || connected || splined) {
      layer_.fail(cursor_.here(), fmt::format("{} has no '='", shown(last)));
    }
    cursor_.skip_blanks();
    if (cursor_.peek() == '(') property.metadata = cursor_.value();
  }

  std::vector<UsdSample> samples(std::string_view dictionary) const {
    if (!dictionary.starts_with('{')) layer_.fail(dictionary, "found no '{' where time samples begin");
    std::vector<UsdSample> found;
    UsdCursor cursor(layer_, dictionary.substr(1, dictionary.size() - 2));
    while (true) {
      cursor.skip_space(",");
      if (cursor.at_end()) break;
      const std::string_view place = cursor.here();
      UsdSample& sample = found.emplace_back();
      if (!to_number(cursor.word(is_number_part), sample.time) || !std::isfinite(sample.time))
        layer_.fail(place, fmt::format("found {}, wanted a time code", shown(place.substr(0, 20))));
      cursor.skip_space();
      if (!cursor.take(':')) layer_.fail(place, "a time code has no ':' behind it");
      cursor.skip_space();
      sample.value = unless_blocked(cursor.value());
    }
    std::ranges::stable_sort(found, {}, &UsdSample::time);
    for (std::size_t i = 1; i < found.size(); ++i)
      if (found[i].time == found[i - 1].time)
        layer_.fail(found[i].value.empty() ? dictionary : found[i].value,
                    fmt::format("two values have the time code {}, wanted one; take one out", found[i].time));
    return found;
  }

  const UsdText& layer_;
  UsdCursor cursor_;
};

/// Numbers of a list, read one by one.
class NumberList {
 public:
  NumberList(const UsdText& layer, std::string_view value) : layer_(layer), value_(value), cursor_(layer, value) {}

  template <class Number>
  std::vector<Number> tuples(int size) {
    std::vector<Number> found;
    expect('[');
    for (skip(); !cursor_.take(']'); skip()) {
      if (size > 1) expect('(');
      for (int i = 0; i < size; ++i) {
        if (i > 0) expect(',');
        skip();
        found.push_back(number<Number>());
      }
      if (size > 1) expect(')');
      skip();
      if (!cursor_.take(',') && cursor_.peek() != ']') expect(',');
    }
    return found;
  }

 private:
  void skip() { cursor_.skip_space(); }

  void expect(char c) {
    skip();
    if (!cursor_.take(c))
      layer_.fail(place(), fmt::format("found {}, wanted '{}'", shown(place().substr(0, 20)), c));
  }

  std::string_view place() const { return cursor_.at_end() ? value_ : cursor_.here(); }

  template <class Number>
  Number number() {
    const std::string_view at = place();
    const std::string_view word = cursor_.word(is_number_part);
    Number value = 0;
    const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
    bool is_one = read.ec == std::errc() && read.ptr == word.data() + word.size();
    if constexpr (std::is_same_v<Number, double>)
      is_one = (is_one || to_number(word, value)) && std::isfinite(value);
    if (!is_one)
      layer_.fail(at, fmt::format("found {}, wanted a {}", shown(word.empty() ? at.substr(0, 20) : word),
                                  std::is_same_v<Number, double> ? "finite number" : "whole number of 32 bits"));
    return value;
  }

  const UsdText& layer_;
  std::string_view value_;
  UsdCursor cursor_;
};

}  // namespace

const UsdProperty* UsdPrim::property(std::string_view name_) const {
  const auto found = std::ranges::find(properties, name_, &UsdProperty::name);
  return found == properties.end() ? nullptr : &*found;
}

const UsdPrim* UsdPrim::child(std::string_view name_) const {
  const auto found = std::ranges::find(children, name_, &UsdPrim::name);
  return found == children.end() ? nullptr : &*found;
}

UsdText::UsdText(std::string file, std::string_view text) : file_(std::move(file)), text_(text) {
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  if (!text.starts_with(usda_head)) {
    std::string begin(text.substr(0, 12));
    std::ranges::replace_if(begin, [](char c) { return (c & 0x80) != 0; }, '?');  // it may be no text
    fail(text, fmt::format("found {}, wanted {}0, the first line of USD as text in UTF-8; write it again",
                           shown(begin), usda_head));
  }
  layer_ = LayerParser(*this, text).parse();
}

std::vector<double> UsdText::tuples(std::string_view value, int size) const {
  return NumberList(*this, value).tuples<double>(size);
}

std::vector<int> UsdText::integers(std::string_view value) const { return NumberList(*this, value).tuples<int>(1); }

std::vector<double> UsdText::numbers(std::string_view value) const {
  std::vector<double> found;
  UsdCursor cursor(*this, value);
  for (cursor.skip_space("(),"); !cursor.at_end(); cursor.skip_space("(),")) {
    const std::string_view place = cursor.here();
    double& number = found.emplace_back();
    if (!to_number(cursor.word(is_number_part), number) || !std::isfinite(number))
      fail(place, fmt::format("found {}, wanted a finite number", shown(place.substr(0, 20))));
  }
  return found;
}

std::vector<std::string_view> UsdText::words(std::string_view value) const {
  std::vector<std::string_view> found;
  UsdCursor cursor(*this, value);
  for (cursor.skip_space("[],"); !cursor.at_end(); cursor.skip_space("[],"))
    found.push_back(usd_unquoted(cursor.value()));
  return found;
}

std::vector<std::string> UsdText::targets(std::string_view value, const std::string& prim) const {
  std::vector<std::string> found;
  for (const std::string_view word : words(value)) found.push_back(usd_absolute(word, prim));
  return found;
}

const UsdPrim* UsdText::prim_at(std::string_view path) const {
  const UsdPrim* prim = path.starts_with('/') ? &layer_ : nullptr;
  path = path.substr(0, path.find('.'));
  while (prim && path.size() > 1) {
    path.remove_prefix(1);
    const std::string_view name = path.substr(0, path.find('/'));
    prim = prim->child(name);
    path.remove_prefix(name.size());
  }
  return prim;
}

std::string_view UsdText::member(std::string_view metadata, std::string_view name) const {
  if (metadata.size() < 2) return {};
  UsdCursor cursor(*this, metadata.substr(1, metadata.size() - 2));
  while (true) {
    cursor.skip_space(";,");
    if (cursor.at_end()) return {};
    std::string_view last;
    for (cursor.skip_space(); is_name_part(cursor.peek()); cursor.skip_space()) last = cursor.word();
    if (!last.empty() && !cursor.take('=')) continue;
    cursor.skip_space();
    const std::string_view value = cursor.value();  // without a name it is a comment
    if (last == name) return value;
    // The file of a reference may have a path and an offset behind it.
    for (cursor.skip_blanks(); cursor.peek() == '<' || cursor.peek() == '('; cursor.skip_blanks()) cursor.value();
  }
}

void UsdText::fail(std::string_view place, const std::string& what) const {
  const std::size_t offset = place.data() ? std::size_t(place.data() - text_.data()) : text_.size();
  throw IoError(fmt::format("{}, line {}: {}", file_, Scanner::line(text_, offset), what));
}

std::string usd_absolute(std::string_view path, std::string prim) {
  if (path.starts_with('/')) return std::string(path);
  while (path.starts_with("..")) {
    prim.resize(std::min(prim.size(), prim.rfind('/')));
    path.remove_prefix(path.starts_with("../") ? 3 : 2);
  }
  if (path.empty() || path == ".") return prim.empty() ? "/" : prim;
  return prim + (path.starts_with('.') ? "" : "/") + std::string(path);
}

std::string_view usd_unquoted(std::string_view value) {
  if (value.empty()) return value;
  const char mark = value.front();
  if (mark != '"' && mark != '\'' && mark != '@' && mark != '<') return value;
  const std::size_t length = mark != '<' && value.size() >= 6 && value[1] == mark && value[2] == mark ? 3 : 1;
  if (value.size() < 2 * length) return {};
  return value.substr(length, value.size() - 2 * length);
}

}  // namespace mq
