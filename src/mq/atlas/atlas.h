#pragma once
/// Where a surface lies in its textures: charts, seams and the defects of the parameterisation
/// (thesis 5.4.1).
///
/// A chart is a set of triangles connected through edges whose two triangles agree on texture and
/// texture coordinates. An edge of the surface where they do not agree is a seam, whether it runs
/// between charts, inside one, or between textures. The texels are the pixels of all textures;
/// a cell (i, j) is the square between the centres of texels (i, j) and (i + 1, j + 1).

#include <vector>

#include "mq/atlas/texel_point.h"
#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/image/wrap.h"
#include "mq/mesh/surface.h"

namespace mq {

struct TextureSize {
  int width = 0;
  int height = 0;
  /// Only of interest where a chart leaves [0,1]: then unspecified means repeat. Where none does,
  /// the texture ends at its border whatever the file says: nobody means the half texel that a
  /// renderer blends in from the opposite side.
  Wrap wrap = Wrap::unspecified;
};

struct AtlasOptions {
  /// Triangles flipped against the rest of their chart. Scans have a sliver or two of them,
  /// which nobody sees; more means that charts fold over themselves. Kept, a fold is integrated
  /// like any other place, and both of its layers read and write the same texels.
  enum class Flipped {
    few,     ///< kept while they cover less than a thousandth of the texels of all charts
    refuse,  ///< refused
    keep     ///< kept
  } flipped = Flipped::few;
};

struct Chart {
  int texture = 0;
  int triangles = 0;
  bool mirrored = false;    ///< most of its area has texture coordinates seen from behind
  int tile_x = 0;           ///< whole tiles taken off its u ...
  int tile_y = 0;           ///< ... and v, to bring it to [0,1] where it fits
  double texel_area = 0;    ///< in texels²
  double surface_area = 0;  ///< model units²

  /// When it is met on a walk over the surface from seam to seam. Where parts of a model share a
  /// piece of texture, as mirrored halves do, the charts with the earliest turns are of the same
  /// part.
  int turn = 0;
};

/// What an edge of a triangle is in the atlas.
enum class EdgeKind : char {
  inside,   ///< both sides agree
  seam,     ///< the surface goes on elsewhere in the textures
  boundary  ///< the surface, or its textured part, ends
};

struct Atlas {
  std::vector<TextureSize> textures;  ///< `wrap` decided
  std::vector<Chart> charts;
  std::vector<int> chart;  ///< per triangle; -1 where nothing is integrated: no texture,
                           ///< no texture coordinates, no area here or on the surface
  std::vector<std::array<TexelPoint, 3>> corners;  ///< per triangle (chart >= 0), tiles taken off
  std::vector<EdgeKind> edges;                     ///< per half-edge of a triangle with chart >= 0
  int seam_count = 0;                              ///< edges of the surface that are seams
  double surface_area = 0;                         ///< of the triangles that have a chart
  double texel_area = 0;                           ///< of the same, in texels²
  Defects defects;

  /// Mean distance on the surface between neighbouring texels, model units.
  double texel_spacing() const;
};

/// Finds charts and seams. Defects (`Atlas::defects`, with ids): triangles without texture
/// coordinates, with coordinates that are not finite or beyond 100 tiles (refused), flipped inside
/// their chart (see `AtlasOptions`), without area in the texture, stretched beyond `max_stretch`,
/// charts outside [0,1], mirrored charts. Throws `InvalidInput` when a triangle names a texture
/// that is not there or a texture has no size.
Atlas make_atlas(const Surface& surface, const std::vector<TextureSize>& textures,
                 const AtlasOptions& options = {}, const Progress& progress = {});

/// Triangles whose ratio of singular values exceeds this are integrated as if it were this
/// (a collapsed triangle would otherwise outweigh all others); they are listed as a defect.
inline constexpr double max_stretch = 1e4;

/// The immersion metric of a triangle in texel coordinates (thesis 2.3, 5.4.2): with g = dπᵀdπ,
/// what the integrals need of it.
struct TexelMetric {
  double density = 0;          ///< √|g|: surface area per texel²
  double a = 0, b = 0, c = 0;  ///< √|g| g⁻¹ = [[a, b], [b, c]], conformally invariant
  double stretch = 1;          ///< ratio of singular values, at least 1, before any limit
};

/// The metric of one triangle with chart >= 0.
TexelMetric texel_metric(const Surface& surface, const Atlas& atlas, int triangle);

}  // namespace mq
