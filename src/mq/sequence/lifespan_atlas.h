#pragma once
/// One texture atlas for an evolving mesh, in space and time (thesis 6.4): texture coordinates that
/// stay where they are as long as a chart lives.

#include <vector>

#include "mq/base/progress.h"
#include "mq/sequence/lifespan_charts.h"
#include "mq/sequence/unwrap.h"

namespace mq {

struct LifespanAtlasOptions {
  UnwrapOptions unwrap;
  ChartingOptions charting;
  int metric_frames = 16;  ///< of a chart's life, over which lengths are averaged
};

/// A chart in the texture, a right prism through space and time.
struct AtlasPrism {
  int first = 0, last = 0;     ///< frames, both included
  std::vector<int> triangles;  ///< ids
  double area = 0;             ///< texels
};

struct LifespanAtlasFrame {
  int charts = 0;
  int renewed = 0;  ///< triangles whose texture coordinates are not those of the frame before
  double occupancy = 0;
  double stretch = 1;  ///< L²
  int flipped = 0;
};

struct LifespanAtlas {
  LifespanCharts charting;
  std::vector<Period> periods;
  std::vector<AtlasPrism> charts;  ///< those of `charting`, cut where they do not lie flat
  std::vector<LifespanAtlasFrame> frames;
  double charts_per_frame = 0;  ///< mean
  double lifespan = 0;          ///< frames that texture coordinates of a triangle last, mean
  double occupancy = 0;         ///< mean over frames
  double bound = 0;             ///< texels of the texture / area of the fullest frame
  std::vector<UnwrapFigures::Seconds> seconds;  ///< "chart", "flatten", "pack"
};

/// Gives every segment of the evolving mesh texture coordinates; what it had of them is replaced.
///
/// Charts are found as in `find_lifespan_charts`; each is unwrapped as by `unwrap` where its frames
/// resemble their mean most, as isometric as can be to the mean metric of up to `metric_frames` of
/// its frames (the thesis takes the first frame alone, which later ones may differ from), and cut
/// into several where it does not lie flat; all are packed with `pack`, each in the frames it lives
/// in, at one density of texels. Texture coordinates are equal to the bit in all frames of a chart.
///
/// Triangles with two equal vertices collapse in a chart at one of them. The same for every unit of
/// length and every number of threads. Throws as `neighbour_graph`, `find_charts` and `pack` do.
LifespanAtlas lay_out(EvolvingMesh& evolving, const LifespanAtlasOptions& options = {},
                      const Progress& progress = {});

}  // namespace mq
