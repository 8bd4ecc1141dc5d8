// As the coarse levels of a texel system (`TexelHierarchy`), from the first level on: points and the
// graph of the matrix. A is scaled so that its mean diagonal value is 1, which keeps single precision
// away from its ends whatever the unit of the model is.

#include "mq/fem/vertex_multigrid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/fem/surface_graph.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/galerkin.h"
#include "mq/linear/mixed_cg.h"

namespace mq {
namespace {

constexpr double stalled = 0.8;          // a level this much of the finer one is not worth it
constexpr double singular_below = 1e-12; // of the trace: Σ A_ij where A·1 = 0, or as good as

StencilLayout layout_without_stencils(int rows) {
  StencilLayout layout;
  layout.rows = rows;
  layout.tiles.assign(1, 0);
  layout.colours.assign(1, 0);
  layout.irregular.resize(std::size_t(rows));
  std::iota(layout.irregular.begin(), layout.irregular.end(), 0);
  return layout;
}

/// Where vertices lie, relative to the first, and how far their closest neighbours are.
SurfacePoints points_of(const SparseMatrix& A, std::span<const Vector3> positions) {
  SurfacePoints points;
  points.positions.resize(positions.size());
  points.spacing.resize(positions.size());
  parallel_for(std::ssize(positions), [&](std::int64_t i) {
    for (int k = 0; k < 3; ++k)
      points.positions[i][std::size_t(k)] = float(positions[i][k] - positions[0][k]);
    double least = std::numeric_limits<double>::infinity();
    for (SparseMatrix::InnerIterator entry(A, int(i)); entry; ++entry)
      if (entry.col() != i)
        least = std::min(least, (positions[i] - positions[entry.col()]).norm());
    points.spacing[i] = std::isfinite(least) ? float(least) : 0;
  });
  return points;
}

class VertexMultigrid final : public LinearSolver {
 public:
  VertexMultigrid(const SparseMatrix& A, std::span<const Vector3> positions,
                  const MultigridOptions& options, const Progress& progress)
      : rows_(int(A.rows())),
        entries_(A.nonZeros()),
        cg_{options.tolerance, options.max_cycles} {
    require(A.rows() == A.cols() && A.rows() == std::ssize(positions) && A.isCompressed(),
            fmt::format("a compressed matrix of {0} × {0} was wanted for {0} vertices, one of {1} × "
                        "{2} was given",
                        positions.size(), A.rows(), A.cols()));
    multigrid_.options.sweeps = options.sweeps;
    if (rows_ > 0) build(A, positions, options, progress);
    setup_seconds_ = watch_.seconds();
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    require(B.rows() == rows_ && X.rows() == rows_ && X.cols() == B.cols(),
            fmt::format("a system of {} rows was given a right-hand side of {} × {} and a first "
                        "guess of {} × {}",
                        rows_, B.rows(), B.cols(), X.rows(), X.cols()));
    SolveReport report;
    if (B.size() > 0)
      report = mixed_conjugate_gradients(multigrid_.levels.front()->matrix, low_, scaling_,
                                         multigrid_, components_, B, X, cg_, progress);
    report.method = "multigrid";
    report.setup_seconds = setup_seconds_;
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    require(A.rows() == rows_ && A.nonZeros() == entries_ && A.isCompressed(),
            fmt::format("a matrix of the pattern the solver was made for ({} rows, {} entries) was "
                        "wanted, one of {} rows and {} entries was given; make another solver for it",
                        rows_, entries_, A.rows(), A.nonZeros()));
    const Stopwatch watch;
    if (rows_ > 0) {
      find_scaling(A);
      take_finest_values(A);
      SparseMatrix matrix = A;
      for (std::size_t l = 0; l < multigrid_.levels.size(); ++l) {
        if (l > 0) take_values(matrix, *multigrid_.levels[l]);
        if (!multigrid_.levels[l]->transfer) break;
        matrix = galerkin(matrix, *multigrid_.levels[l]->transfer, progress);
        progress.at(double(l) / double(multigrid_.levels.size()));
      }
      find_singular(A);
      multigrid_.coarsest =
          CoarsestLevel(scaling_.common * matrix, coarsest_component_, components_.singular);
    }
    setup_seconds_ = watch.seconds();
  }

 private:
  void build(const SparseMatrix& A, std::span<const Vector3> positions,
             const MultigridOptions& options, const Progress& progress) {
    SurfacePoints points = points_of(A, positions);
    find_scaling(A);
    SparseMatrix matrix = A;
    while (multigrid_.levels.empty() || matrix.rows() > options.coarsest_rows) {
      GraphCoarsening graph = coarsen_graph(matrix, points, options.graph_radius);
      const bool worth_it = graph.transfer->coarse_rows() <= stalled * double(matrix.rows());
      if (!worth_it && !multigrid_.levels.empty()) break;
      auto level = std::make_unique<MultigridLevel>();
      level->layout = layout_without_stencils(int(matrix.rows()));
      level->patches = Patches(matrix, level->layout, Patches::Kind::single);
      level->transfer = std::move(graph.transfer);
      multigrid_.levels.push_back(std::move(level));
      if (multigrid_.levels.size() == 1)
        take_finest_values(A);
      else
        take_values(matrix, *multigrid_.levels.back());
      matrix = galerkin(matrix, *multigrid_.levels.back()->transfer, progress);
      points = std::move(graph.coarse);
      progress.at(1 - double(matrix.rows()) / rows_);
    }
    label_components(matrix);
    find_singular(A);
    multigrid_.coarsest =
        CoarsestLevel(scaling_.common * matrix, coarsest_component_, components_.singular);
    progress.at(1);
  }

  void find_scaling(const SparseMatrix& A) {
    const double trace = A.diagonal().sum();
    scaling_ = {};
    scaling_.common = trace > 0 && std::isfinite(trace) ? double(rows_) / trace : 1;
  }

  void take_finest_values(const SparseMatrix& A) {
    MultigridLevel& level = *multigrid_.levels.front();
    take_values(A, level);
    level.matrix.keep_row_sums(A, scaling_);
    low_ = StencilMatrix::remainder(A, level.layout, scaling_);
  }

  void take_values(const SparseMatrix& A, MultigridLevel& level) {
    level.matrix = StencilMatrix(A, level.layout, scaling_);
    level.patches.set_values(A, level.layout, scaling_);
  }

  /// Parts of the coarsest level are parts of all.
  void label_components(const SparseMatrix& coarsest) {
    coarsest_component_ = connected_components(coarsest);
    std::vector<int> labels = coarsest_component_;
    for (std::size_t l = multigrid_.levels.size(); l-- > 0;) {
      const MultigridLevel& level = *multigrid_.levels[l];
      std::vector<int> finer(std::size_t(level.layout.rows));
      parallel_for(level.layout.rows, [&](std::int64_t i) {
        std::array<WeightedIndex, 4> parents;
        level.transfer->parents(int(i), parents);
        finer[i] = labels[std::size_t(parents[0].index)];
      });
      labels = std::move(finer);
    }
    int count = 0;
    for (const int c : labels) count = std::max(count, c + 1);
    components_.singular.assign(std::size_t(count), 0);
    components_.component.clear();
    if (count > 1) components_.component = std::move(labels);
  }

  void find_singular(const SparseMatrix& A) {
    const std::size_t count = components_.singular.size();
    std::vector<double> sum(count, 0), trace(count, 0);
    components_.size.assign(count, 0);
    for (int row = 0; row < rows_; ++row) {
      const auto c = std::size_t(components_.component.empty() ? 0 : components_.component[row]);
      components_.size[c] += 1;
      for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
        sum[c] += entry.value();
        if (entry.col() == row) trace[c] += entry.value();
      }
    }
    for (std::size_t c = 0; c < count; ++c)
      components_.singular[c] = std::abs(sum[c]) <= singular_below * trace[c];
  }

  Stopwatch watch_;  ///< first of all members: it times the making of the others
  int rows_ = 0;
  std::int64_t entries_ = 0;
  MixedCgOptions cg_;
  Multigrid multigrid_;
  StencilMatrix low_;
  Scaling scaling_;
  Components components_;
  std::vector<int> coarsest_component_;  ///< per row of the coarsest level
  double setup_seconds_ = 0;
};

}  // namespace

SolverFactory vertex_multigrid_solver(std::span<const Vector3> positions,
                                      const MultigridOptions& options) {
  return [positions, options](const SparseMatrix& A,
                              const Progress& progress) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<VertexMultigrid>(A, positions, options, progress);
  };
}

}  // namespace mq
