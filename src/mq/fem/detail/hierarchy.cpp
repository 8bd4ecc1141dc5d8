#include "mq/fem/detail/hierarchy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/galerkin.h"

namespace mq {

namespace {

constexpr double stalled = 0.8;      // a level this much of the finer one's size is not worth it
constexpr double weak_below = 1e-6;  // of the largest diagonal value around: gets its own unit
constexpr double singular_below = 1e-12;  // of the trace: Σ A_ij where A·1 = 0, or as good as

std::vector<double> diagonal_of(const StencilRows& A, const StencilLayout& layout) {
  std::vector<double> diagonal(std::size_t(A.rows()), 0.0);
  parallel_for(std::ssize(layout.runs), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[r];
    for (int k = run.first; k < run.first + run.count; ++k) diagonal[k] = A.at(k, Coupling::centre);
  }, 64);
  parallel_for(std::ssize(layout.irregular), [&](std::int64_t p) {
    const int row = layout.irregular[p];
    for (SparseMatrix::InnerIterator entry(A.listed(), row); entry; ++entry)
      if (entry.col() == row) diagonal[row] += entry.value();
  });
  return diagonal;
}

class HierarchySolver final : public LinearSolver {
 public:
  HierarchySolver(Hierarchy hierarchy, double setup_seconds)
      : hierarchy_(std::move(hierarchy)),
        options_{hierarchy_.options().tolerance, hierarchy_.options().max_cycles},
        setup_seconds_(setup_seconds) {}

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    require(B.rows() == hierarchy_.rows() && X.rows() == B.rows() && X.cols() == B.cols(),
            fmt::format("a system of {} rows was given a right-hand side of {} × {} and a first "
                        "guess of {} × {}",
                        hierarchy_.rows(), B.rows(), B.cols(), X.rows(), X.cols()));
    SolveReport report;
    if (B.size() > 0)
      report = mixed_conjugate_gradients(hierarchy_.high(), hierarchy_.low(), hierarchy_.scaling(),
                                         hierarchy_.multigrid(), hierarchy_.components(), B, X,
                                         options_, progress);
    report.method = "multigrid";
    report.setup_seconds = setup_seconds_;
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    const Stopwatch watch;
    hierarchy_.set_values(A, progress);
    setup_seconds_ = watch.seconds();
  }

  void take(StencilSystem&& A, const Progress& progress) override {
    const Stopwatch watch;
    hierarchy_.set_values(std::move(A), progress);
    setup_seconds_ = watch.seconds();
  }

 private:
  Hierarchy hierarchy_;
  MixedCgOptions options_;
  double setup_seconds_;
};

}  // namespace

Hierarchy::Hierarchy(int rows, std::int64_t entries, const MultigridOptions& options)
    : options_(options), rows_(rows), entries_(entries) {
  multigrid_.options.sweeps = options.sweeps;
}

SparseMatrix Hierarchy::add_level(StencilRows rows, StencilLayout layout, PatchSmoother::Kind kind,
                                  std::unique_ptr<LevelTransfer> transfer, const Progress& progress) {
  auto level = std::make_unique<MultigridLevel>();
  level->layout = std::move(layout);
  level->patches = PatchSmoother(rows.listed(), level->layout, kind);
  level->transfer = std::move(transfer);
  multigrid_.levels.push_back(std::move(level));
  return take_values(std::move(rows), multigrid_.levels.size() - 1, progress);
}

void Hierarchy::add_graph_levels(const SparseMatrix& finest, SurfacePoints points, StencilLayout layout,
                                 PatchSmoother::Kind kind, const Progress& progress, SparseMatrix& coarsest) {
  const SparseMatrix* matrix = &finest;
  points = in_own_unit(std::move(points));
  while (multigrid_.levels.empty() || matrix->rows() > options_.coarsest_rows) {
    GraphCoarsening graph = coarsen_graph(*matrix, points, options_.graph_radius);
    if (!multigrid_.levels.empty() &&
        graph.transfer->coarse_rows() > stalled * double(matrix->rows()))
      break;
    StencilRows rows(*matrix, layout);
    SparseMatrix next = add_level(std::move(rows), std::move(layout), kind, std::move(graph.transfer), progress);
    coarsest.swap(next);
    matrix = &coarsest;
    points = std::move(graph.coarse);
    layout = layout_without_stencils(int(matrix->rows()));
    kind = PatchSmoother::Kind::single;
    progress.at(1 - double(matrix->rows()) / rows_);
  }
  if (matrix == &finest && matrix != &coarsest) coarsest = finest;
}

void Hierarchy::finish(const SparseMatrix& coarsest) {
  label_components(coarsest);
  take_coarsest_values(coarsest);
}

void Hierarchy::require_pattern(std::int64_t rows, std::int64_t entries) const {
  require(rows == rows_ && entries == entries_,
          fmt::format("a matrix of the pattern the solver was made for ({} rows, {} entries) was "
                      "wanted, one of {} rows and {} entries was given; make another solver for it",
                      rows_, entries_, rows, entries));
}

void Hierarchy::set_values(const SparseMatrix& A, const Progress& progress) {
  require_square(A, rows_);
  require_pattern(A.rows(), A.nonZeros());
  if (rows_ > 0) take_all_values(StencilRows(A, multigrid_.levels.front()->layout), progress);
}

void Hierarchy::set_values(StencilSystem&& A, const Progress& progress) {
  require_pattern(A.rows.rows(), A.rows.entries());
  if (rows_ == 0) return;
  A.layout = {};
  const StencilLayout& layout = multigrid_.levels.front()->layout;
  A.rows.list_clustered(layout);
  take_all_values(std::move(A.rows), progress);
}

void Hierarchy::take_all_values(StencilRows&& A, const Progress& progress) {
  SparseMatrix matrix = take_values(std::move(A), 0, progress);
  for (std::size_t l = 1; l < multigrid_.levels.size(); ++l) {
    SparseMatrix next = take_values(StencilRows(matrix, multigrid_.levels[l]->layout), l, progress);
    matrix.swap(next);
    progress.at(double(l) / double(multigrid_.levels.size()));
  }
  take_coarsest_values(matrix);
}

/// Returns the matrix of the next level. The finest level keeps the units of weak rows and what single precision leaves
/// of A; the others have the common scale alone.
SparseMatrix Hierarchy::take_values(StencilRows&& rows, std::size_t l, const Progress& progress) {
  MultigridLevel& level = *multigrid_.levels[l];
  const bool finest = l == 0;
  if (finest) find_scaling(rows);
  const Scaling common{scaling_.common, {}, {}};
  const Scaling& scaling = finest ? scaling_ : common;
  level.patches.set_values(rows.listed(), level.layout, scaling);
  SparseMatrix next = galerkin(rows, level.layout, *level.transfer, progress);
  if (finest) {
    StencilMatrix::Split split = StencilMatrix::split(std::move(rows), level.layout, scaling);
    level.matrix = std::move(split.high);
    low_ = std::move(split.low);
    level.rescaled = scaling.special;
  } else {
    level.matrix = StencilMatrix(std::move(rows), level.layout, scaling);
  }
  return next;
}

void Hierarchy::take_coarsest_values(const SparseMatrix& coarsest) {
  find_singular(coarsest);
  multigrid_.coarsest =
      CoarsestLevel(scaling_.common * coarsest, coarsest_component_, components_.singular);
}

void Hierarchy::find_scaling(const StencilRows& A) {
  const std::vector<double> diagonal = diagonal_of(A, multigrid_.levels.front()->layout);
  const double trace = parallel_sum(A.rows(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    return std::accumulate(diagonal.begin() + begin, diagonal.begin() + end, 0.0);
  });
  trace_ = trace;
  scaling_ = {};
  scaling_.common = trace > 0 && std::isfinite(trace) ? double(A.rows()) / trace : 1;

  const std::vector<int>& rows = multigrid_.levels.front()->layout.irregular;
  std::vector<float> weight(rows.size(), 0.0f);  // 0: none of its own
  parallel_for(std::ssize(rows), [&](std::int64_t p) {
    const double own = diagonal[rows[p]];
    double largest = own;
    for (SparseMatrix::InnerIterator entry(A.listed(), rows[p]); entry; ++entry)
      largest = std::max(largest, diagonal[entry.col()]);
    if (own > 0 && own < weak_below * largest)
      weight[p] = float(1 / std::exp2(std::round(0.5 * std::log2(largest / own))));
  });
  for (std::size_t p = 0; p < rows.size(); ++p)
    if (weight[p] > 0) scaling_.special.push_back({rows[p], weight[p]});
  if (scaling_.special.empty()) return;
  scaling_.rows.assign(rows_, 1.0f);
  for (const WeightedIndex& row : scaling_.special) scaling_.rows[row.index] = 1 / row.weight;
}

/// What is connected on the coarsest level is on all.
void Hierarchy::label_components(const SparseMatrix& coarsest) {
  coarsest_component_ = connected_components(coarsest, Joining::pattern);
  int count = 0;
  for (const int c : coarsest_component_) count = std::max(count, c + 1);
  components_.singular.assign(count, 0);
  components_.component.clear();
  if (count == 1) return;
  std::vector<int> labels = coarsest_component_;
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

/// Σ A_ij over a component is that of the coarsest matrix, as rows of transfers sum to 1.
void Hierarchy::find_singular(const SparseMatrix& coarsest) {
  const std::size_t count = components_.singular.size();
  std::vector<double> sum(count, 0), trace(count, 0);
  for (int row = 0; row < coarsest.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(coarsest, row); entry; ++entry)
      sum[coarsest_component_[row]] += entry.value();
  components_.size.assign(count, 0);
  if (components_.component.empty() && scaling_.special.empty()) {
    components_.size[0] = double(rows_);
    trace[0] = trace_;
  } else {
    for (int row = 0; row < rows_; ++row) {
      const int c = components_.component.empty() ? 0 : components_.component[row];
      const double unit = scaling_.row(row) * scaling_.row(row);
      components_.size[c] += 1 / unit;
      trace[c] += double(high().centre(row)) / (unit * scaling_.common);
    }
  }
  for (std::size_t c = 0; c < count; ++c)
    components_.singular[c] = std::abs(sum[c]) <= singular_below * trace[c];
}

std::int64_t Hierarchy::bytes() const {
  return multigrid_.bytes() + low_.bytes() +
         4 * std::int64_t(components_.component.size() + scaling_.rows.size());
}

void require_square(const SparseMatrix& A, std::int64_t nodes) {
  require(
      A.rows() == A.cols() && A.rows() == nodes && A.isCompressed(),
      fmt::format("a compressed matrix of {0} × {0} was wanted for {0} unknowns, one of {1} × {2} "
                  "was given",
                  nodes, A.rows(), A.cols()));
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

std::unique_ptr<LinearSolver> hierarchy_solver(Hierarchy hierarchy, double setup_seconds) {
  return std::make_unique<HierarchySolver>(std::move(hierarchy), setup_seconds);
}

}  // namespace mq
