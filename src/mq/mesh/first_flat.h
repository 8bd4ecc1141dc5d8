#pragma once
/// How far vertices of triangles in the plane may move before one flips.

#include <span>

#include "mq/mesh/mesh.h"

namespace mq {

/// The least s > 0 at which a triangle of the places x + s·direction is flat; infinite where none
/// becomes so. All are counter-clockwise at x.
double first_flat(std::span<const Triangle> triangles, std::span<const Vector2> x,
                  std::span<const Vector2> direction);

}  // namespace mq
