#pragma once
/// Charts in space and time (thesis 6.4.2; [prada2017atlas]).
///
/// A chart is a right prism through the neighbour graph: connected triangles, all of them over the
/// same periods I. Its caps are twice its mean area, its sides the perimeters of all its frames:
///
///   ‖C‖_C = 2/|I| Σ_{i∈I} |C(i)|,  ‖C‖_S = Σ_{i∈I} |∂C(i)|,
///   E(C) = ‖C‖_C / A + β r/F ‖C‖_S / ‖C‖_C
///
/// with the mean area A of a frame, the radius r of a triangle, and the number F of all frames. The
/// thesis has neither A, so that its energy depends on the unit of length, nor F, so that it
/// depends on how many frames show the same motion: sides grow with them, caps do not.

#include <cstdint>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/neighbour_graph.h"

namespace mq {

struct ChartingOptions {
  double beta = 1;  ///< weight of coherence in space against that in time
  enum class Edits {
    descend,  ///< greedy descent
    none      ///< the charts that it begins with: neighbours with equal lives
  } edits = Edits::descend;
  int frames = 0;  ///< F; 0: those of the graph

  /// What is over and cannot be changed: so many periods, and per chain that begins in one of them
  /// a number of the chart it is in, equal for those that are in one; −1 for all others. Chains that begin
  /// right after the past may have one as well: they were added to that chart.
  int past = 0;
  std::vector<int> chart_of = {};
};

struct LifespanChart {
  std::vector<int> chains;  ///< of the graph, increasing
  int first = 0, last = 0;  ///< periods, both included
  int goes_on = -1;  ///< the number of the chart of the past that it is a part of; −1: it is new
};

struct LifespanCharts {
  std::vector<LifespanChart> charts;  ///< by their first period, then their first chain
  double first_energy = 0;            ///< of the charts it began with
  double energy = 0;
  int first_charts = 0;
  int edits = 0;
};

/// Begins with neighbours that live through the same periods; then, as long as there is an edit
/// that lowers the energy, makes the one that lowers it most: two neighbours become one for all
/// periods that they have in common, what is left of either before and after becomes a chart of
/// its own. Two neighbours with equal lives never remain.
///
/// With a past, charts that began in it begin as they are, parted by how long their triangles live
/// on, and edits concern the periods after it: a chart that is joined to another is left as it was
/// in the past and ends there; parts of one chart, whose texture coordinates agree as long as they
/// are left alone, are not joined.
///
/// Energies are whole multiples of 2⁻²⁴, so that the sum kept over all edits is that of the charts
/// found, exactly. About 2 µs per edit and neighbour; the same bits for any number of threads.
LifespanCharts find_lifespan_charts(const NeighbourGraph& graph,
                                    const ChartingOptions& options = {},
                                    const Progress& progress = {});

/// E of charts, computed from nothing but the graph.
double charting_energy(const NeighbourGraph& graph, const std::vector<LifespanChart>& charts,
                       double beta);

/// A chart that loses triangles while it lives: no prism.
struct WaningChart {
  int first = 0;               ///< period
  std::vector<int> chains;     ///< of the graph
  std::vector<int> last = {};  ///< period, per chain
};

/// The same of such charts: caps are those of triangles, each for as long as it is there, 2 Σ mean
/// area; sides the perimeters of what is there. So it is E where nothing is lost.
double charting_energy(const NeighbourGraph& graph, const std::vector<WaningChart>& charts,
                       double beta);

}  // namespace mq
