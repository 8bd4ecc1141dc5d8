#pragma once
/// A model whose shape has changed: the vertices of its surface are elsewhere.

#include <optional>
#include <span>

#include "mq/model/textured_model.h"

namespace mq {

/// A measure of a shape as it was and as it is.
struct BeforeAfter {
  double before = 0, after = 0;

  /// after / before − 1; nothing where there was none.
  std::optional<double> change() const;
};

struct ShapeChange {
  double rms_moved = 0;      ///< of vertices, model units
  double largest_moved = 0;  ///< the same of the one that moved most
  BeforeAfter area;
  std::optional<BeforeAfter> volume;  ///< of closed surfaces
};

/// What other positions, one per vertex, make of a surface.
ShapeChange shape_change(const Surface& surface, std::span<const Vector3> positions);

/// Moves the vertices of a model as those of its surface move to these positions: copies that were
/// welded alike, each from where it was, and those that stay keep their bits. Where one moved,
/// normals that the model's file says are turned by the smallest rotations that turn the surface's
/// own at vertices, and the file is forgotten, to be made anew: true then. The surface stays as it
/// is.
bool move_vertices(std::span<const Vector3> positions, TexturedModel& model);

}  // namespace mq
