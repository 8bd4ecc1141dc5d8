#pragma once
/// A texture atlas for a surface: charts, their parametrisation, and their places in the texture
/// (thesis 6.4.3, 6.4.4; [prada2017atlas]).

#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/surface.h"
#include "mq/unwrap/atlas_stretch.h"

namespace mq {

struct UnwrapOptions {
  int width = 2048, height = 2048;  ///< of the texture, texels
  int gutter = 2;                   ///< free texels between charts
  double stretch = 1.05;            ///< the most L² stretch that may come of making charts fewer
  int trials = 200;                 ///< orders of packing that are tried
  double largest = 0.2;  ///< the most of the area that a chart may have; from 1 on no chart is too
                         ///< long for the texture either
};

struct UnwrapFigures {
  int charts = 0;
  int overlapping = 0;  ///< charts that cover a place twice
  double seam_length =
      0;  ///< of cuts on the surface, in square roots of its area; borders not counted
  AtlasStretch stretch;
  struct Seconds {
    std::string step;
    double seconds;
  };
  std::vector<Seconds> seconds;  ///< "charts", "flatten", "pack"
};

struct Unwrapped {
  std::vector<Vector2> uvs;          ///< in [0, 1]; a vertex has one per chart it is in, or per fan
                                     ///< of a chart where that is cut
  std::vector<Triangle> corner_uvs;  ///< of every triangle
  std::vector<int> chart;            ///< per triangle
  UnwrapFigures figures;
};

/// Unwraps a whole surface, of any topology and any number of components. Charts are discs; each is
/// laid out with the least symmetric Dirichlet energy found, without a flipped triangle and
/// without overlap: where that fails, the last gluing of the chart is taken back. All charts have
/// the one density of texels at which the L² stretch of the whole is least, and are packed.
///
/// Triangles without area lie between their neighbours; those with two equal vertices, which have
/// no neighbours, collapse in a chart at one of their vertices.
///
/// The surface is moved and scaled to a box of size 1 and rounded to multiples of 2⁻³² of it first,
/// so that its units do not matter. The same bits for any number of threads. Throws `InvalidInput`
/// for a surface without area, and as `pack` does.
Unwrapped unwrap(const Surface& surface, const UnwrapOptions& options = {},
                 const Progress& progress = {});

}  // namespace mq
