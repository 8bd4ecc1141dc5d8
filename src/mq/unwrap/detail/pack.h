#pragma once
/// Places for flat charts in a texture, or in a texture video (thesis 6.4.4).

#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// A chart in the plane, in units of its own that are the same for all charts.
struct PackChart {
  std::vector<std::vector<Vector2>>
      loops;                ///< its boundary; inside is what an odd number surrounds
  double area = 0;          ///< of its triangles
  int first = 0, last = 0;  ///< frames it lives in, both included; its place is the same in all
};

struct PackOptions {
  int width = 1024, height = 1024;  ///< texels
  int gutter = 2;                   ///< texels that stay free between charts that live together
  int trials = 200;                 ///< orders that are tried; fewer where charts are many
  std::uint64_t seed = 1;
};

/// Where a chart lies: its point p at scale · R(angle) · p + shift, in texels from the lower left
/// corner, y upward.
struct Placement {
  double angle = 0;  ///< radians, counter-clockwise
  Vector2 shift = Vector2::Zero();
};

struct Packing {
  std::vector<Placement> places;
  double scale = 0;      ///< texels per unit, the same for all
  double occupancy = 0;  ///< Σ area · frames lived / (width · height · frames), in texels
  double bound = 0;      ///< width · height / the area of the fullest frame: 1 would be perfect
};

/// Places all charts at the largest scale found. A chart has the texels that it touches, in one of
/// sixteen directions (every 22.5° from where its box is smallest, never mirrored). Between two charts
/// with a frame in common `gutter` texels stay free in rows, columns and diagonals, and half of
/// them (rounded up) at the border, so that charts stay apart where a texture repeats; exactly.
///
/// Charts are placed by falling area, each where the least of the texture's height (or of the
/// square from its corner) is lost; in many orders near to that at a quarter of the resolution,
/// then in the best at the full one. The texture of a frame is that of all charts alive, seen
/// through time: a segment tree over frames holds them. Textures of more than 2048 texels a side
/// are packed in cells of several texels.
///
/// Throws `InvalidInput` where there is no chart with area, or where the gutters alone fill the
/// texture (it says which size would do).
Packing pack(const std::vector<PackChart>& charts, const PackOptions& options = {},
             const Progress& progress = {});

/// Places for charts of one frame at this scale (texels per unit), the largest first, beside what is
/// `taken`: polygons in texels from the lower left corner, y upward, which keep all texels that they
/// touch. `gutter` and borders are as above. None: there is no room for a chart. `first` and `last`
/// of the charts must be equal.
std::vector<std::optional<Placement>> pack_beside(const std::vector<PackChart>& charts, double scale,
                                                  const std::vector<std::vector<Vector2>>& taken,
                                                  const PackOptions& options = {},
                                                  const Progress& progress = {});

/// Texels that a placed chart touches: per texel of the texture, row 0 on top, 1 or 0.
std::vector<char> touched_texels(const PackChart& chart, const Placement& place, double scale,
                                 int width, int height);

}  // namespace mq
