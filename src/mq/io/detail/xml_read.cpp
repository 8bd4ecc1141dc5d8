#include "mq/io/detail/xml_read.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {

XmlFile::XmlFile(std::string file, ByteView bytes, const std::string& wanted)
    : file_(std::move(file)), text_(text_of(bytes)) {
  const pugi::xml_parse_result found = document_.load_buffer(bytes.data(), bytes.size());
  if (!found)
    throw IoError(fmt::format("{}, line {}: not XML from here on: {} (wanted {})", file_,
                              Scanner::line(text_, std::min(std::size_t(found.offset), text_.size())),
                              found.description(), wanted));
}

std::string XmlFile::place(const pugi::xml_node& node) const {
  const auto at = node.offset_debug();  // no offset of documents in other encodings than UTF-8
  if (at < 0 || std::size_t(at) > text_.size()) return fmt::format("{}: {}", file_, node.name());
  return fmt::format("{}, line {}: {}", file_, Scanner::line(text_, std::size_t(at)), node.name());
}

void XmlFile::refuse(const pugi::xml_node& node, const std::string& what) const {
  throw IoError(place(node) + ": " + what);
}

std::vector<double> XmlFile::numbers(const pugi::xml_node& node, std::string_view text,
                                     std::size_t count, const std::string& what) const {
  std::vector<double> found;
  std::string words(text);
  for (char& c : words)
    if (c == '\n' || c == '\r') c = ' ';
  Scanner at(words);
  for (std::string_view word = at.word(); !word.empty(); word = at.word()) {
    double value = 0;
    if (!to_number(word, value) || !std::isfinite(value))
      refuse(node, fmt::format("{}: found '{}', wanted a number", what, shown(word)));
    found.push_back(value);
  }
  if (found.size() != count)
    refuse(node, fmt::format("{}: found {} numbers, wanted {}", what, found.size(), count));
  return found;
}

double XmlFile::number(const pugi::xml_node& node, const char* child, double otherwise) const {
  const pugi::xml_node found = node.child(child);
  return found ? numbers(found, found.text().get(), 1, child)[0] : otherwise;
}

}  // namespace mq
