#pragma once
/// A model's shape changed: new positions put into it, and what that made of its size.

#include <optional>
#include <span>

#include "mq/mesh/surface.h"
#include "mq/model/textured_model.h"

namespace mq {

struct ShapeChange {
  double rms_moved = 0, largest_moved = 0;  ///< of vertices of the surface

  struct Size {
    double before = 0, after = 0;
    std::optional<double> share() const {  ///< of what it was; nothing where that is 0
      return before != 0 ? std::optional(after / before - 1) : std::nullopt;
    }
  };
  Size area;
  std::optional<Size> volume;  ///< of closed surfaces
};

/// What becomes of the surface with these positions of its vertices.
ShapeChange shape_change(const Surface& surface, std::span<const Vector3> positions);

enum class StoredNormals {
  kept,
  left_out  ///< they were those of the shape before; the file is made anew, without comments, skins or
            ///< animations
};

/// Puts new positions of the surface's vertices into the model. Welded copies move alike, each from
/// where it was; a vertex that does not move keeps its bits, and where none does all is kept.
StoredNormals put_positions(std::span<const Vector3> positions, TexturedModel& model);

}  // namespace mq
