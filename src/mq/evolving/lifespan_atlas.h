#pragma once
/// One texture atlas for an evolving mesh, in space and time (thesis 6.4): texture coordinates that
/// stay where they are as long as a chart lives.

#include <limits>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/lifespan_charts.h"
#include "mq/unwrap/unwrap.h"

namespace mq {

struct LifespanAtlasOptions {
  UnwrapOptions unwrap;
  ChartingOptions charting;
  int metric_frames = 16;  ///< of a chart's life, over which lengths are averaged

  /// How many frames after one are known when it gets its texture coordinates.
  int look_ahead = std::numeric_limits<int>::max();
};

/// A chart in the texture, a right prism through space and time.
struct AtlasPrism {
  int first = 0, last = 0;     ///< frames, both included
  std::vector<int> triangles;  ///< ids
  double area = 0;             ///< texels
};

struct LifespanAtlasFrame {
  int charts = 0;   ///< connected pieces of the surface in the texture
  int added = 0;    ///< triangles that were not there in the frame before
  int renewed = 0;  ///< these, and triangles whose texture coordinates are not those they had
  double occupancy = 0;
  double stretch = 1;  ///< L²
  int flipped = 0;
};

struct LifespanAtlas {
  LifespanCharts charting;     ///< its charts: none where they were not all planned at once
  double energy_of_whole = 0;  ///< that of the charts found when the whole sequence is known
  int plans = 0;               ///< how often charts were planned
  std::vector<int> cleared;    ///< frames from which on all of the texture is new
  std::vector<Period> periods;
  std::vector<AtlasPrism> charts;  ///< those of `charting`, cut where they do not lie flat
  std::vector<LifespanAtlasFrame> frames;
  double charts_per_frame = 0;  ///< mean
  double lifespan = 0;          ///< frames that texture coordinates of a triangle last, mean
  double occupancy = 0;         ///< mean over frames
  double bound = 0;             ///< texels of the texture / area of the fullest frame
  double stretch = 1;           ///< L², in the worst frame
  int flipped = 0;              ///< triangles, in all frames
  int moved = 0;                ///< renewed though they were there before, in all frames
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
/// With a look-ahead texture coordinates of a frame depend on no frame farther ahead: an atlas for
/// a sequence that goes on while it is made. In each segment triangles that are new
/// are laid beside the charts around them: discs all around
/// which one chart goes on into its hole (`filled_hole`), others as a whole beside one chart, or parted between
/// several (`extended_chart`), where all of them fit with the gutter. Small charts are moved so, too; and up to
/// three rings of triangles with either, where it does not fit without. Then charts are planned of what is left and of
/// those that are there, with what was given in the past as it was, and no more of it counting than its last frame:
/// charts that begin then, of new triangles and of charts that end for them. Sides count for as long as triangles will
/// live, those that are known to go on for as long as they are known and what `Survival` expects beyond, learned from
/// all triangles so far; F is twice the number of frames from the first to the last one known. Triangles keep their
/// texture coordinates when others of their chart die. Charts that begin
/// are laid flat by the frames known of them and placed beside those
/// that go on, at the density there is; what finds no room is halved. Where a piece of a few
/// triangles finds none, everything is planned and packed anew (`cleared`), at the density that
/// then fits. 1/32 of the texture's height is left free in that, and at first; where less than 62 % of the texture is
/// filled then, charts are cut to 0.9 and 0.8 of the usual size, too, and what fills most is taken. A look-ahead
/// that shows the whole sequence at once gives the atlas that none gives.
///
/// `charting.energy` is that of charts which lose triangles (`WaningChart`).
///
/// Triangles with two equal vertices collapse in a chart at one of them. The same for every unit of
/// length and every number of threads. Throws as `neighbour_graph`, `find_charts` and `pack` do.
LifespanAtlas lay_out(EvolvingMesh& evolving, const LifespanAtlasOptions& options = {},
                      const Progress& progress = {});

}  // namespace mq
