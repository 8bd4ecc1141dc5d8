/// Level 0 has the texels, level 1 a grid of half the resolution in each chart (thesis 5.8.1). From
/// there on charts are forgotten: a chart-wise grid not much finer than the charts cannot represent
/// smooth functions across seams, which is what makes coarse levels of the thesis' kind fail on
/// atlases of many charts. All matrices are scaled so that the mean diagonal value of A is 1, which
/// keeps single precision away from its ends whatever the unit of the model is. Texels of hardly
/// any influence (a corner of their footprint at a seam) get a unit of their own in which they are
/// not negligible: their rows and columns would else be lost in the rounding of the others.

#include "mq/fem/texel_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/grid_levels.h"
#include "mq/linear/galerkin.h"

namespace mq {

namespace {

constexpr double stalled = 0.8;      // a level this much of the finer one's size is not worth it
constexpr double weak_below = 1e-6;  // of the largest diagonal value around: gets its own unit
constexpr double singular_below =
    1e-12;  // of the trace: Σ A_ij where A·1 = 0, or as good as

/// rows / trace, so that `scale`·A has a mean diagonal value of 1.
double common_scale(const SparseMatrix& A) {
  const double trace = parallel_sum(A.rows(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t row = begin; row < end; ++row)
      for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
        if (entry.col() == row) sum += entry.value();
    return sum;
  });
  return trace > 0 && std::isfinite(trace) ? double(A.rows()) / trace : 1;
}

/// Per node how close its neighbours are along the axis where they are closer. Nodes without a
/// stencil take the mean of the neighbours that have one, else of their chart; in charts without any
/// stencil they ask the neighbours in the grid that they have, else take the mean of all.
std::vector<float> spacings(const SparseMatrix& A, const Texels& grid,
                            const StencilLayout& layout) {
  const auto distance = [&](int a, int b) {
    double squared = 0;
    for (int i = 0; i < 3; ++i)
      squared += std::pow(double(grid.positions[a][i]) - grid.positions[b][i], 2);
    return std::sqrt(squared);
  };
  int charts = 0;
  for (const int c : grid.chart) charts = std::max(charts, c + 1);
  std::vector<float> result(grid.size(), -1);
  std::vector<double> sum(charts + 1, 0), count(charts + 1, 0);
  for (const StencilRun& run : layout.runs)
    for (int i = 0; i < run.count; ++i) {
      const int k = run.first + i;
      result[k] = float(0.5 * std::min(distance(k - 1, k + 1), distance(run.up + i, run.down + i)));
      for (const int c : {grid.chart[k], charts}) {
        sum[c] += result[k];
        count[c] += 1;
      }
    }
  if (count[charts] == 0)  // charts so small that none has a stencil: neighbours in a row
    for (int k = 0; k + 1 < grid.size(); ++k)
      if (grid.chart[k] == grid.chart[k + 1] && grid.places[k].y == grid.places[k + 1].y) {
        sum[charts] += distance(k, k + 1);
        count[charts] += 1;
      }
  // The lesser of the mean distances along x and y of neighbours in the chart's grid; 0: it has none.
  const auto to_grid_neighbours = [&](int k) {
    const Texels::Place& here = grid.places[k];
    double along[2] = {0, 0}, found[2] = {0, 0};
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      const int j = int(entry.col());
      const int dx = std::abs(grid.places[j].x - here.x), dy = std::abs(grid.places[j].y - here.y);
      if (grid.chart[j] != grid.chart[k] || dx + dy != 1) continue;
      along[dy] += distance(k, j);
      found[dy] += 1;
    }
    if (found[0] == 0 || found[1] == 0) return (along[0] + along[1]) / std::max(1.0, found[0] + found[1]);
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

StencilLayout layout_without_stencils(int rows) {
  StencilLayout layout;
  layout.rows = rows;
  layout.tiles.assign(1, 0);
  layout.colours.assign(1, 0);
  layout.irregular.resize(rows);
  std::iota(layout.irregular.begin(), layout.irregular.end(), 0);
  return layout;
}

}  // namespace

TexelHierarchy::TexelHierarchy(const SparseMatrix& A, const Texels& texels,
                               const MultigridOptions& options, const Progress& progress)
    : rows_(int(A.rows())), entries_(A.nonZeros()) {
  require(
      A.rows() == A.cols() && A.rows() == texels.size() && A.isCompressed(),
      fmt::format("a compressed matrix of {0} × {0} was wanted for {0} texels, one of {1} × {2} "
                  "was given",
                  texels.size(), A.rows(), A.cols()));
  multigrid_.options.sweeps = options.sweeps;
  if (rows_ > 0) build(A, texels, options, progress);
}

void TexelHierarchy::build(const SparseMatrix& A, const Texels& texels,
                           const MultigridOptions& options, const Progress& progress) {
  const auto add_level = [&](StencilLayout layout, const SparseMatrix& matrix, Patches::Kind kind) {
    auto level = std::make_unique<MultigridLevel>();
    level->layout = std::move(layout);
    level->patches = Patches(matrix, level->layout, kind);
    multigrid_.levels.push_back(std::move(level));
  };
  add_level(make_robust_layout(A, texels), A, Patches::Kind::neighbours);
  find_scaling(A);
  take_finest_values(A);
  progress.at(0.3);

  MultigridLevel& finest = *multigrid_.levels.front();
  GridCoarsening grid =
      coarsen_grid(texels, coarsening_steps(texels, finest.layout, options.max_stretch));
  finest.transfer = std::move(grid.transfer);
  SparseMatrix matrix = galerkin(A, *finest.transfer, progress);
  progress.at(0.6);

  StencilLayout layout = make_robust_layout(matrix, grid.coarse);
  SurfacePoints points;
  points.spacing = spacings(matrix, grid.coarse, layout);
  points.positions = std::move(grid.coarse.positions);
  Patches::Kind kind = Patches::Kind::neighbours;
  while (matrix.rows() > options.coarsest_rows) {
    GraphCoarsening graph = coarsen_graph(matrix, points, options.graph_radius);
    if (graph.transfer->coarse_rows() > stalled * double(matrix.rows())) break;
    add_level(std::move(layout), matrix, kind);
    multigrid_.levels.back()->transfer = std::move(graph.transfer);
    take_values(matrix, int(multigrid_.levels.size()) - 1);
    matrix = galerkin(matrix, *multigrid_.levels.back()->transfer, progress);
    points = std::move(graph.coarse);
    layout = layout_without_stencils(int(matrix.rows()));
    kind = Patches::Kind::single;
  }
  label_components(matrix);
  find_singular(A);
  take_coarsest_values(std::move(matrix));
  progress.at(1);
}

void TexelHierarchy::set_values(const SparseMatrix& A, const Progress& progress) {
  require(A.rows() == rows_ && A.cols() == rows_ && A.nonZeros() == entries_ && A.isCompressed(),
          fmt::format("a matrix of the pattern the solver was made for ({} rows, {} entries) was "
                      "wanted, one of {} rows and {} entries was given; make another solver for it",
                      rows_, entries_, A.rows(), A.nonZeros()));
  if (rows_ == 0) return;
  find_scaling(A);
  take_finest_values(A);
  SparseMatrix matrix = galerkin(A, *multigrid_.levels.front()->transfer, progress);
  for (int l = 1; l < int(multigrid_.levels.size()); ++l) {
    take_values(matrix, l);
    matrix = galerkin(matrix, *multigrid_.levels[l]->transfer, progress);
    progress.at(double(l) / double(multigrid_.levels.size()));
  }
  find_singular(A);
  take_coarsest_values(std::move(matrix));
}

void TexelHierarchy::take_values(const SparseMatrix& A, int l) {
  MultigridLevel& level = *multigrid_.levels[l];
  const Scaling common{scaling_.common, {}, {}};
  level.matrix = StencilMatrix(A, level.layout, common);
  level.patches.set_values(A, level.layout, common);
}

void TexelHierarchy::find_scaling(const SparseMatrix& A) {
  scaling_ = {};
  scaling_.common = common_scale(A);
  for (const int k : multigrid_.levels.front()->layout.irregular) {
    const double own = A.coeff(k, k);
    double largest = own;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      largest = std::max(largest, A.coeff(entry.col(), entry.col()));
    if (!(own > 0 && own < weak_below * largest)) continue;
    const double factor = std::exp2(std::round(0.5 * std::log2(largest / own)));
    scaling_.special.push_back({k, float(1 / factor)});
  }
  if (scaling_.special.empty()) return;
  scaling_.rows.assign(rows_, 1.0f);
  for (const WeightedIndex& row : scaling_.special) scaling_.rows[row.index] = 1 / row.weight;
}

void TexelHierarchy::take_finest_values(const SparseMatrix& A) {
  MultigridLevel& level = *multigrid_.levels.front();
  level.matrix = StencilMatrix(A, level.layout, scaling_);
  level.matrix.keep_row_sums(A, scaling_);
  level.patches.set_values(A, level.layout, scaling_);
  level.rescaled = scaling_.special;
  low_ = StencilMatrix::remainder(A, level.layout, scaling_);
}

void TexelHierarchy::take_coarsest_values(SparseMatrix A) {
  multigrid_.coarsest =
      CoarsestLevel(scaling_.common * A, coarsest_component_, components_.singular);
}

void TexelHierarchy::label_components(const SparseMatrix& coarsest) {
  const int n = int(coarsest.rows());
  std::vector<int>& label = coarsest_component_;
  label.assign(n, -1);
  int count = 0;
  std::vector<int> stack;
  for (int seed = 0; seed < n; ++seed) {
    if (label[seed] >= 0) continue;
    label[seed] = count;
    stack.push_back(seed);
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      for (SparseMatrix::InnerIterator entry(coarsest, i); entry; ++entry)
        if (label[entry.col()] < 0) {
          label[entry.col()] = count;
          stack.push_back(int(entry.col()));
        }
    }
    ++count;
  }
  components_.singular.assign(count, 0);
  components_.component.clear();
  if (count == 1) return;
  std::vector<int> labels = label;
  for (int l = int(multigrid_.levels.size()) - 1; l >= 0; --l) {
    const MultigridLevel& level = *multigrid_.levels[l];
    std::vector<int> finer(level.layout.rows);
    parallel_for(level.layout.rows, [&](std::int64_t i) {
      std::array<WeightedIndex, 4> parents;
      level.transfer->parents(int(i), parents);
      finer[i] = labels[parents[0].index];
    });
    labels = std::move(finer);
  }
  components_.component = std::move(labels);
}

void TexelHierarchy::find_singular(const SparseMatrix& A) {
  const std::size_t count = components_.singular.size();
  std::vector<double> sum(count, 0), trace(count, 0);
  components_.size.assign(count, 0);
  for (int row = 0; row < rows_; ++row) {
    const int c = components_.component.empty() ? 0 : components_.component[row];
    components_.size[c] += 1 / (scaling_.row(row) * scaling_.row(row));
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
      sum[c] += entry.value();
      if (entry.col() == row) trace[c] += entry.value();
    }
  }
  for (std::size_t c = 0; c < count; ++c)
    components_.singular[c] = std::abs(sum[c]) <= singular_below * trace[c];
}

std::int64_t TexelHierarchy::bytes() const {
  return multigrid_.bytes() + low_.bytes() +
         4 * std::int64_t(components_.component.size() + scaling_.rows.size());
}

}  // namespace mq
