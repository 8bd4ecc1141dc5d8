#pragma once
/// One frame of a texture video: what a captured frame shows, in the atlas of another surface that
/// lies on it (thesis 6.5.1).

#include <array>
#include <cstdint>
#include <functional>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/mesh/closest_point.h"

namespace mq {

struct TextureFrameOptions {
  int width = 1024, height = 1024;  ///< texels
  int samples = 2;                  ///< per texel and direction, 1 to 8
  double most_distance = 0.02;      ///< from the captured surface, in its diagonals
  double most_angle = 90;           ///< between normals of both, degrees
};

struct TextureFrame {
  Image<float> picture;     ///< red, green and blue
  Image<char> inside;       ///< 1: a texel of a chart
  std::int64_t texels = 0;  ///< of charts: those whose square a triangle touches
  std::int64_t unseen = 0;  ///< of these: nothing was captured near enough, facing alike
};

/// The colour at a point of the captured mesh.
using ColourAt = std::function<std::array<float, 3>(const ClosestPoint&)>;

/// Every texel of a chart has the mean colour at the captured points closest to its samples, where
/// they lie on the surface; those outside the chart count where it ends. Texels outside charts,
/// and those that nothing was captured for, have the colour of the nearest texel that has one;
/// where there is none at all, black.
///
/// Equal bits for any number of threads. Throws `InvalidInput` where `surface` has no texture
/// coordinates or a mesh has no triangles, and for options out of range. About 2 µs per sample.
TextureFrame resample_texture(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                              const TextureFrameOptions& options = {},
                              const Progress& progress = {});

}  // namespace mq
