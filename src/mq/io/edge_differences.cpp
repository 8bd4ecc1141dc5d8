#include "mq/io/edge_differences.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

/// A way to say where both ends of a pair are.
struct Naming {
  EdgeDifferences::At at;
  std::vector<std::string_view> columns;
  std::vector<std::array<int, 2>> slots;  ///< per column which end, and which of its three numbers
};

const std::vector<Naming>& namings() {
  using At = EdgeDifferences::At;
  static const std::vector<Naming> known{
      {At::texels,
       {"texture", "column", "row", "to_texture", "to_column", "to_row"},
       {{0, 0}, {0, 1}, {0, 2}, {1, 0}, {1, 1}, {1, 2}}},
      {At::texels, {"column", "row", "to_column", "to_row"}, {{0, 1}, {0, 2}, {1, 1}, {1, 2}}},
      {At::vertices, {"vertex", "to_vertex"}, {{0, 0}, {1, 0}}}};
  return known;
}

constexpr double largest = 1e30;  ///< sums of squares of more are no numbers

std::string_view trimmed(std::string_view word) {
  const auto begin = word.find_first_not_of(" \t\r"), end = word.find_last_not_of(" \t\r");
  return begin == std::string_view::npos ? std::string_view() : word.substr(begin, end - begin + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0;;) {
    const std::size_t comma = line.find(',', at);
    words.push_back(trimmed(line.substr(at, comma - at)));
    if (comma == std::string_view::npos) return words;
    at = comma + 1;
  }
}

const Naming* naming_of(const std::vector<std::string_view>& head) {
  for (const Naming& naming : namings())
    if (head.size() > naming.columns.size() && std::equal(naming.columns.begin(), naming.columns.end(), head.begin()))
      return &naming;
  return nullptr;
}

/// Lines of a text that are not empty, one after another.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  std::optional<std::string_view> next() {
    while (!text_.empty()) {
      const std::size_t end = std::min(text_.find('\n'), text_.size());
      const std::string_view line = trimmed(text_.substr(0, end));
      text_.remove_prefix(std::min(end + 1, text_.size()));
      ++number_;
      if (!line.empty()) return line;
    }
    return {};
  }
  int number() const { return number_; }

 private:
  std::string_view text_;
  int number_ = 0;
};

}  // namespace

std::string EdgeDifferences::words(const Place& place) const {
  if (at == At::vertices) return fmt::format("vertex {}", place[0]);
  return (place[0] > 0 ? fmt::format("texture {}, ", place[0]) : std::string()) +
         fmt::format("column {}, row {}", place[1], place[2]);
}

EdgeDifferences read_edge_differences(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  const std::string name = path.string();
  std::string_view text = text_of(bytes);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // as spreadsheets begin a file
  Lines lines(text);
  const std::optional<std::string_view> first = lines.next();
  const std::vector<std::string_view> head = split(first.value_or(""));
  const Naming* naming = naming_of(head);
  if (!naming)
    throw IoError(fmt::format("{}: line {}: found {}, wanted names of columns: column,row,to_column,to_row,value, or "
                              "texture,column,row,to_texture,to_column,to_row,value, or vertex,to_vertex,value, with as many "
                              "values as there are channels, or one for all",
                              name, std::max(lines.number(), 1), shown(first.value_or(""))));
  const std::size_t places = naming->columns.size();
  EdgeDifferences table{.at = naming->at, .names_textures = naming->slots.size() == 6, .pairs = {}, .channels = int(head.size() - places), .values = {}};
  while (const std::optional<std::string_view> line = lines.next()) {
    const std::vector<std::string_view> words = split(*line);
    const std::string place = fmt::format("{}: line {}", name, lines.number());
    if (words.size() != head.size())
      throw IoError(fmt::format("{}: found {} numbers, wanted {}, one for each column named in the first line", place,
                                words.size(), head.size()));
    EdgeDifferences::Pair pair{.from = {}, .to = {}, .line = lines.number()};
    for (std::size_t k = 0; k < words.size(); ++k) {
      double value = 0;
      if (!to_number(words[k], value) || !(std::abs(value) <= largest))
        throw IoError(fmt::format("{}: {}: found {}, wanted a number of {} at most", place, head[k], shown(words[k]), largest));
      if (k >= places) {
        table.values.push_back(value);
        continue;
      }
      if (value != std::floor(value) || value < 0 || value > 2e9)
        throw IoError(fmt::format("{}: {}: found {}, wanted a whole number from 0", place, head[k], value));
      (naming->slots[k][0] ? pair.to : pair.from)[std::size_t(naming->slots[k][1])] = int(value);
    }
    table.pairs.push_back(pair);
  }
  if (table.pairs.empty()) throw IoError(name + ": has no pairs below the names of its columns");
  return table;
}

}  // namespace mq
