/// Level 0 has the texels, level 1 a grid of half the resolution in each chart (thesis 5.8.1). From
/// there on charts are forgotten: a chart-wise grid not much finer than the charts cannot represent
/// smooth functions across seams, which is what makes coarse levels of the thesis' kind fail on
/// atlases of many charts.

#include "mq/fem/texel_hierarchy.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/fem/grid_levels.h"

namespace mq {

namespace {

/// Per node how close its neighbours are along the axis where they are closer. Nodes without a
/// stencil take the mean of the neighbours that have one, else of their chart; in charts without
/// any stencil they ask the neighbours in the grid that they have, else take the mean of all.
std::vector<float> spacings(const SparseMatrix& A, const Texels& grid,
                            const StencilLayout& layout) {
  const int charts = grid.chart_count();
  std::vector<float> result(grid.size(), -1);
  std::vector<double> sum(charts + 1, 0), count(charts + 1, 0);
  for (const StencilRun& run : layout.runs)
    for (int i = 0; i < run.count; ++i) {
      const int k = run.first + i;
      result[k] = float(
          0.5 * std::sqrt(std::min(grid.squared_distance(k - 1, k + 1),
                                   grid.squared_distance(run.up + i, run.down + i))));
      for (const int c : {grid.chart[k], charts}) {
        sum[c] += result[k];
        count[c] += 1;
      }
    }
  if (count[charts] == 0)  // charts so small that none has a stencil: neighbours in a row
    for (int k = 0; k + 1 < grid.size(); ++k)
      if (grid.chart[k] == grid.chart[k + 1] && grid.places[k].y == grid.places[k + 1].y) {
        sum[charts] += grid.distance(k, k + 1);
        count[charts] += 1;
      }
  // The lesser of the mean distances along x and y of neighbours in the chart's grid; 0: it has
  // none.
  const auto to_grid_neighbours = [&](int k) {
    const Texels::Place& here = grid.places[k];
    double along[2] = {0, 0}, found[2] = {0, 0};
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      const int j = int(entry.col());
      const int dx = std::abs(grid.places[j].x - here.x), dy = std::abs(grid.places[j].y - here.y);
      if (grid.chart[j] != grid.chart[k] || dx + dy != 1) continue;
      along[dy] += grid.distance(k, j);
      found[dy] += 1;
    }
    if (found[0] == 0 || found[1] == 0)
      return (along[0] + along[1]) / std::max(1.0, found[0] + found[1]);
    return std::min(along[0] / found[0], along[1] / found[1]);
  };
  std::vector<float> around(layout.irregular.size());
  parallel_for(std::int64_t(layout.irregular.size()), [&](std::int64_t p) {
    const int k = layout.irregular[p];
    double near = 0, nears = 0;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      if (const int j = int(entry.col()); result[j] >= 0 && grid.chart[j] == grid.chart[k]) {
        near += result[j];
        nears += 1;
      }
    const int c = grid.chart[k];
    if (nears > 0)
      around[p] = float(near / nears);
    else if (count[c] > 0)
      around[p] = float(sum[c] / count[c]);
    else if (const double own = to_grid_neighbours(k); own > 0)
      around[p] = float(own);
    else
      around[p] = float(count[charts] > 0 ? sum[charts] / count[charts] : 0);
  });
  for (std::size_t p = 0; p < around.size(); ++p) result[layout.irregular[p]] = around[p];
  return result;
}

}  // namespace

Hierarchy texel_hierarchy(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options,
                          const Progress& progress) {
  require_square(A, texels.size());
  StencilLayout layout = make_layout(A, texels);
  StencilRows rows(A, layout);
  return texel_hierarchy({std::move(layout), std::move(rows)}, texels, options, progress);
}

Hierarchy texel_hierarchy(StencilSystem&& A, const Texels& texels, const MultigridOptions& options,
                          const Progress& progress) {
  Hierarchy hierarchy(A.rows.rows(), A.rows.entries(), options);
  if (texels.size() == 0) return hierarchy;
  A.layout.clustered = find_clustered(A.rows, A.layout);
  A.rows.list_clustered(A.layout);
  GridCoarsening grid = coarsen_grid(texels, coarsening_steps(texels, A.layout, options.max_stretch));
  part_sheets(A.rows.listed(), texels, A.layout, grid);
  progress.at(0.3);
  SparseMatrix matrix = hierarchy.add_level(std::move(A.rows), std::move(A.layout), PatchSmoother::Kind::neighbours,
                                            std::move(grid.transfer), progress);
  progress.at(0.6);

  StencilLayout layout = make_robust_layout(matrix, grid.coarse);
  SurfacePoints points;
  points.spacing = spacings(matrix, grid.coarse, layout);
  // What flows through a shared texel changes fast around it: coarser levels stay close there.
  for (const int k : find_contacts(matrix, grid.coarse, layout)) {
    points.kept.resize(points.spacing.size(), 0);
    points.kept[k] = 1;
    points.spacing[k] *= 0.4F;  // no neighbour reaches it then
  }
  points.positions = std::move(grid.coarse.positions);
  hierarchy.add_graph_levels(matrix, std::move(points), std::move(layout), PatchSmoother::Kind::neighbours, progress,
                             matrix);
  hierarchy.finish(matrix);
  progress.at(1);
  return hierarchy;
}

}  // namespace mq
