#pragma once
/// Material libraries of OBJ files: which picture each material names.

#include <string>
#include <vector>

#include "mq/io/bytes.h"
#include "mq/io/document.h"

namespace mq {

/// A material and its `map_Kd`.
struct Material {
  std::string name;
  std::string picture;  ///< as the file spells it; empty: it names none
  Place place;          ///< of the picture's name, or where a line that gives one belongs
  Vector2 scale{1, 1};  ///< -s and -o: the picture is looked up at scale · uv + offset
  Vector2 offset{0, 0};
  Wrap wrap = Wrap::unspecified;  ///< -clamp
};

/// Reads the materials of a library in their order. Lines of other meaning are passed over; a
/// library without any is one without materials.
std::vector<Material> parse_mtl(ByteView bytes);

/// A library of materials with these names and pictures, the picture of each `map_Kd`.
std::string new_mtl(const std::vector<Material>& materials);

}  // namespace mq
