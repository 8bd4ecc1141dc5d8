#pragma once
/// One frame of a texture video: what a captured frame shows, in the atlas of another surface that
/// lies on it (thesis 6.5.1).

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/stitch.h"
#include "mq/image/image.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/facing_points.h"

namespace mq {

struct TextureFrameOptions {
  int width = 1024, height = 1024;    ///< texels
  int samples = 2;                    ///< per texel and direction, 1 to 8
  FacingPointsOptions points = {};  ///< what is believed

  /// Per captured triangle the chart it is in, negative: in none; steps where texels come from
  /// different ones are taken out (`stitch_regions`). None: all are kept.
  std::vector<int> captured_charts = {};
  double alpha = 100;  ///< how far that spreads: weight of gradients on the surface of unit area
};

struct TextureFrame {
  Image<float> picture;     ///< red, green and blue
  Image<char> inside;       ///< 1: a texel of a chart
  std::int64_t texels = 0;  ///< of charts: those whose square a triangle touches
  std::int64_t unseen = 0;  ///< of these: no sample of them has a captured point
  std::int64_t filled = 0;  ///< of these: have values from the surface around them
  double accuracy = 0;      ///< of the surface, see `FacingPoints`; model units

  /// Steps across borders of captured charts, and within them, before and after they were taken
  /// out; 0 where that was not asked for.
  BorderJump before, after;
};

/// The colour at a point of the captured mesh.
using ColourAt = std::function<std::array<float, 3>(const ClosestPoint&)>;

/// Every texel of a chart has the mean colour of the captured points that show its samples (see
/// `FacingPoints`); those outside the chart count where it ends. Texels that nothing was captured
/// for are filled over the surface (`fill_unseen`), across charts and seams; on a piece of it of
/// which nothing was captured, and where the atlas has defects that are refused, they have the
/// colour of the nearest texel in the picture that has one, as do texels outside charts; where
/// there is none at all, black.
///
/// Equal bits for any number of threads. Throws `InvalidInput` where `surface` has no texture
/// coordinates or a mesh has no triangles, and for options out of range; where steps are taken out,
/// as `TexelSpace` does. About 4 µs per sample, and
/// where something is unseen the set-up of a texel space.
TextureFrame resample_texture(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                              const TextureFrameOptions& options = {},
                              const Progress& progress = {});

struct VertexColours {
  Signal colours;           ///< a row of red, green and blue per vertex
  std::int64_t unseen = 0;  ///< filled over the surface
  double accuracy = 0;      ///< as above
};

/// The same at the vertices of the surface, each with the captured point that shows it.
VertexColours resample_vertices(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                                const FacingPointsOptions& options = {});

}  // namespace mq
