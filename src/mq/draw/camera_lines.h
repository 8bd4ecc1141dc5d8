#pragma once
/// Cameras of photographs as one sees them from outside: frusta, and what lies in them.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/draw/pinhole.h"
#include "mq/draw/render.h"

namespace mq {

/// The direction, in the model and unit, in which the lens would show a place of the picture were it
/// without distortion (a `Lens` with `projection` and `shape` alone).
Vector3 undistorted_direction(const PinholeCamera& camera, double x, double y);

/// Each camera as lines: four edges from where it stands, `length` long, the picture's frame between
/// their ends, a line through the middle, half as long again, and a small roof over its upper edge.
std::vector<SpaceLine> lines_of_cameras(std::span<const PinholeCamera> cameras, double length,
                                        const Colour& colour = {0.85F, 0.2F, 0.1F});

/// For each triangle how many cameras have its middle in their picture, whatever is in front of it.
std::vector<int> views_of_triangles(const Mesh& mesh, std::span<const PinholeCamera> cameras,
                                    const Progress& progress = {});

}  // namespace mq
