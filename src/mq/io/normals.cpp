#include "mq/io/normals.h"

#include <algorithm>

#include "mq/io/bytes.h"
#include "mq/io/document.h"
#include "mq/io/detail/ply.h"

namespace mq {
namespace {

bool obj_says_normals(std::string_view text) {
  for (Scanner scanner(text); !scanner.at_end(); scanner.next_line())
    if (scanner.word() == "vn") return true;
  return false;
}

bool ply_says_normals(const Document& document) {
  for (const PlyElement& element : parse_ply_header(document.bytes, document.name).elements)
    if (element.name == "vertex")
      for (const PlyProperty& property : element.properties)
        if (property.name == "nx" || property.name == "normal_x") return true;
  return false;
}

}  // namespace

bool holds_normals(const Model& model) {
  if (!model.document) return false;
  switch (model.document->format) {
    case Document::Format::obj: return obj_says_normals(text_of(model.document->bytes));
    case Document::Format::ply: return ply_says_normals(*model.document);
    default: return text_of(model.document->bytes).find("\"NORMAL\"") != std::string_view::npos;
  }
}

bool leave_out_normals(Model& model) {
  if (!holds_normals(model)) return false;
  model.document.reset();
  return true;
}

}  // namespace mq
