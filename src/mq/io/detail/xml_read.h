#pragma once
/// XML as a user gives it: what is wrong with it is said by file and line.

#include <pugixml.hpp>
#include <string>
#include <vector>

#include "mq/io/bytes.h"

namespace mq {

/// A document and the bytes it is of, which must stay.
class XmlFile {
 public:
  /// Throws `IoError` with the line at which it is no XML; `wanted` says what it should be.
  XmlFile(std::string file, ByteView bytes, const std::string& wanted);

  pugi::xml_node root() const { return document_.document_element(); }

  /// "FILE, line 12: camera", where a node begins.
  std::string place(const pugi::xml_node& node) const;

  /// So many finite numbers; `what` says of what. Throws `IoError`.
  std::vector<double> numbers(const pugi::xml_node& node, std::string_view text, std::size_t count,
                              const std::string& what) const;

  /// The number that the child of this name holds; `otherwise` where it is not there.
  double number(const pugi::xml_node& node, const char* child, double otherwise) const;

  [[noreturn]] void refuse(const pugi::xml_node& node, const std::string& what) const;

 private:
  std::string file_;
  std::string_view text_;
  pugi::xml_document document_;
};

}  // namespace mq
