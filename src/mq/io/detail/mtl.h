#pragma once
/// Material libraries of OBJ files: which pictures each material names, and what it says beside them.

#include <string>
#include <vector>

#include "mq/io/bytes.h"
#include "mq/io/document.h"
#include "mq/io/materials.h"

namespace mq {

/// A picture that a material names, and what for.
struct MaterialMap {
  std::string slot;     ///< (slots.h)
  std::string picture;  ///< as the file spells it
  Place place;          ///< of the picture's name
  Vector2 scale{1, 1};  ///< -s and -o: the picture is looked up at scale · uv + offset
  Vector2 offset{0, 0};
  Wrap wrap = Wrap::unspecified;  ///< -clamp
};

struct MtlMaterial {
  std::string name;
  std::vector<MaterialMap> maps;  ///< at most one for each slot: of several the last
  Place end;                      ///< where a line that gives a base colour belongs
  Material look = {};             ///< what it says beside them, its name too

  /// The map of a slot, or null.
  const MaterialMap* map(const std::string& slot) const;
};

/// Reads the materials of a library in their order. Numbers that are none or not finite are passed over;
/// a library without materials is one. Kd and Ke count where no picture stands for them: programs write
/// any there that do.
std::vector<MtlMaterial> parse_mtl(ByteView bytes);

/// A library of materials with these names, looks and pictures. Slots must be such as MTL has a keyword
/// for.
std::string new_mtl(const std::vector<MtlMaterial>& materials);

}  // namespace mq
