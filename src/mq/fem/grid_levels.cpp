// How charts are coarsened, and the next coarser grid.

#include "mq/fem/grid_levels.h"

#include <algorithm>

#include "mq/base/parallel.h"
#include "mq/fem/detail/node_position.h"

namespace mq {

namespace {

using Place = Texels::Place;

int floor_half(int x) { return x >> 1; }
int below(int x, int step) { return step == 1 ? x : floor_half(x); }
int above(int x, int step) { return step == 1 ? x : floor_half(x + 1); }

/// Unknowns `items[begin]` … `items[end − 1]`: one row of one chart, from left to right.
struct GridRow {
  int chart, texture, y, begin, end;
};

struct FineRows {
  std::vector<int> items;  ///< unknowns by chart, row, column
  std::vector<GridRow> rows;
};

FineRows rows_of(const Texels& texels) {
  FineRows result;
  const int n = texels.size();
  const int charts = texels.chart_count();
  std::vector<int> at(charts + 1, 0);
  for (const int c : texels.chart) ++at[c + 1];
  for (int c = 0; c < charts; ++c) at[c + 1] += at[c];
  result.items.resize(n);
  for (int k = 0; k < n; ++k) result.items[at[texels.chart[k]]++] = k;
  for (int i = 0; i < n; ++i) {
    const int k = result.items[i];
    const Place& p = texels.places[k];
    if (i == 0 || result.rows.back().chart != texels.chart[k] || result.rows.back().y != p.y)
      result.rows.push_back({texels.chart[k], p.texture, p.y, i, i});
    result.rows.back().end = i + 1;
  }
  return result;
}

/// A coarse row and the fine rows (indices into FineRows::rows, −1: none) above, on and below it.
struct CoarseRow {
  int chart, texture, y;
  std::array<int, 3> fine = {-1, -1, -1};
  std::vector<int> columns;
  int begin = 0;  ///< its first node
};

std::vector<CoarseRow> coarse_rows(const Texels& texels, const FineRows& fine,
                                   const std::vector<GridStep>& steps) {
  std::vector<CoarseRow> rows;
  for (int f = 0; f < int(fine.rows.size()); ++f) {
    const GridRow& row = fine.rows[f];
    const int step = steps[row.chart].y;
    for (int y = below(row.y, step); y <= above(row.y, step); ++y) {
      // Rows of a chart come from top to bottom: a coarse row is the last or the last but one.
      int found = -1;
      for (int i = int(rows.size()) - 1; i >= 0 && i >= int(rows.size()) - 2; --i)
        if (rows[i].chart == row.chart && rows[i].y == y) found = i;
      if (found < 0) {
        found = int(rows.size());
        rows.push_back({row.chart, row.texture, y, {-1, -1, -1}, {}, 0});
      }
      rows[found].fine[row.y - step * y + 1] = f;
    }
  }
  parallel_for(
      std::int64_t(rows.size()),
      [&](std::int64_t i) {
        CoarseRow& row = rows[i];
        const int step = steps[row.chart].x;
        for (const int f : row.fine) {
          if (f < 0) continue;
          for (int item = fine.rows[f].begin; item < fine.rows[f].end; ++item) {
            const int x = texels.places[fine.items[item]].x;
            for (int column = below(x, step); column <= above(x, step); ++column)
              if (row.columns.empty() || row.columns.back() != column)
                row.columns.push_back(column);
          }
        }
        std::sort(row.columns.begin(), row.columns.end());
        row.columns.erase(std::unique(row.columns.begin(), row.columns.end()), row.columns.end());
      },
      16);
  int begin = 0;
  for (CoarseRow& row : rows) {
    row.begin = begin;
    begin += int(row.columns.size());
  }
  return rows;
}

/// Fills the parents of one fine row from the coarse row `upper` (between_rows 0: the only one).
void link_parents(const Texels& texels, const FineRows& fine, const GridRow& row,
                  const CoarseRow& upper, const CoarseRow& lower, int step, bool between_rows,
                  std::vector<GridTransfer::Parents>& parents) {
  std::size_t u = 0, l = 0;
  for (int item = row.begin; item < row.end; ++item) {
    const int k = fine.items[item], x = texels.places[k].x, column = below(x, step);
    while (upper.columns[u] < column) ++u;
    while (lower.columns[l] < column) ++l;
    GridTransfer::Parents& p = parents[k];
    p.upper = std::uint32_t(upper.begin + int(u));
    p.lower = lower.begin + int(l);
    p.between_columns = above(x, step) != column;
    p.between_rows = between_rows;
  }
}

/// Fills row `i` (above, on, below) of the children of a coarse row's nodes.
void link_children(const Texels& texels, const FineRows& fine, const GridRow& row,
                   const CoarseRow& coarse, int i, int step,
                   std::vector<GridTransfer::Children>& children) {
  int item = row.begin;
  for (std::size_t c = 0; c < coarse.columns.size(); ++c) {
    const int x = step * coarse.columns[c], reach = step - 1;
    while (item < row.end && texels.places[fine.items[item]].x < x - reach) ++item;
    GridTransfer::Children& node = children[coarse.begin + int(c)];
    for (int j = item; j < row.end; ++j) {
      const int k = fine.items[j], dx = texels.places[k].x - x;
      if (dx > reach) break;
      node.flags[i] |= dx < 0 ? 1 : dx == 0 ? 2 : 4;
      if (dx < 0) node.centre[i] = k + 1;
      if (dx == 0 || !(node.flags[i] & 3)) node.centre[i] = k;
      if (dx > 0 && k != node.centre[i]) node.flags[i] |= 8;
    }
  }
}

}  // namespace

std::vector<GridStep> coarsening_steps(const Texels& texels, const StencilLayout& layout,
                                       double max_ratio) {
  const int charts = texels.chart_count();
  std::vector<std::array<double, 2>> of_run(layout.runs.size());
  parallel_for(std::ssize(of_run), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[r];
    for (int i = 0; i < run.count; ++i) {
      of_run[r][0] += texels.distance(run.first + i, run.first + i + 1);
      of_run[r][1] += texels.distance(run.first + i, run.down + i);
    }
  }, 64);
  std::vector<double> along_x(charts, 0), along_y(charts, 0);
  for (std::size_t r = 0; r < of_run.size(); ++r) {
    const int chart = texels.chart[layout.runs[r].first];
    along_x[chart] += of_run[r][0];
    along_y[chart] += of_run[r][1];
  }
  std::vector<GridStep> steps(charts);
  for (int c = 0; c < charts; ++c) {
    if (along_x[c] > max_ratio * along_y[c]) steps[c] = {1, 2};
    if (along_y[c] > max_ratio * along_x[c]) steps[c] = {2, 1};
  }
  return steps;
}

GridCoarsening coarsen_grid(const Texels& texels, const std::vector<GridStep>& steps) {
  const FineRows fine = rows_of(texels);
  const std::vector<CoarseRow> rows = coarse_rows(texels, fine, steps);
  const int nodes = rows.empty() ? 0 : rows.back().begin + int(rows.back().columns.size());

  // Per fine row the coarse rows above (or on) and below it.
  std::vector<std::array<int, 2>> rows_of_parents(fine.rows.size(), {-1, -1});
  for (int r = 0; r < int(rows.size()); ++r)
    for (int i = 0; i < 3; ++i)
      if (const int f = rows[r].fine[i]; f >= 0) {
        if (i == 1) rows_of_parents[f] = {r, r};
        if (i == 0) rows_of_parents[f][1] = r;
        if (i == 2) rows_of_parents[f][0] = r;
      }

  std::vector<GridTransfer::Parents> parents(texels.size());
  parallel_for(
      std::int64_t(fine.rows.size()),
      [&](std::int64_t f) {
        const auto [upper, lower] = rows_of_parents[f];
        link_parents(texels, fine, fine.rows[f], rows[upper], rows[lower],
                     steps[rows[upper].chart].x, upper != lower, parents);
      },
      16);

  GridCoarsening result;
  Texels& coarse = result.coarse;
  coarse.places.resize(nodes);
  coarse.chart.resize(nodes);
  std::vector<GridTransfer::Children> children(nodes);
  parallel_for(
      std::int64_t(rows.size()),
      [&](std::int64_t r) {
        const CoarseRow& row = rows[r];
        for (int i = 0; i < 3; ++i)
          if (row.fine[i] >= 0)
            link_children(texels, fine, fine.rows[row.fine[i]], row, i, steps[row.chart].x,
                          children);
        for (std::size_t c = 0; c < row.columns.size(); ++c) {
          coarse.places[row.begin + c] = {row.texture, row.columns[c], row.y};
          coarse.chart[row.begin + c] = row.chart;
        }
      },
      16);
  result.transfer = std::make_unique<GridTransfer>(std::move(parents), std::move(children));

  coarse.positions.resize(nodes);
  parallel_blocks(nodes, 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<WeightedIndex> list;
    for (std::int64_t node = begin; node < end; ++node)
      coarse.positions[node] = node_position(texels, *result.transfer, int(node), list);
  });
  return result;
}

}  // namespace mq
