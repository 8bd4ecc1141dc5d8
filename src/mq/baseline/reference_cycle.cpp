/// The V-cycle of thesis 5.8.2. With i the interior texels of a level, b its boundary texels:
///
///     down  r_i = b_i − A_ib x_b,  x_i ← n sweeps on A_ii x_i = r_i     R.2, R.3
///           r_b = b_b − A_bi x_i,  x_b = A_bb⁻¹ r_b                      R.4, R.5
///           b^{l+1} = Pᵀ (b − A x)                                      R.6
///     up    x ← x + P x^{l+1}                                           P.2
///           x_b as in R.4 and R.5, then x_i as in R.2 and R.3           P.3 to P.6
///
/// R.2 and R.3 are one step: a stencil takes its neighbours at the boundary where they stand.
///
/// What the thesis leaves open, and what is done here:
/// - Corrections x^{l+1} start from 0 (its listing forgets to say so).
/// - L = 4 hierarchy levels count the texels and the coarsest grid, as in the authors' program,
///   though the listing has L + 1. One grid more or less changes the factor per cycle by a few
///   percent.
/// - Sweeps go from top to bottom and left to right on the way down and on the way up (its 5.8.5
///   knows one order only), so that the cycle is no symmetric operator.
/// - Blocks are 128 × 16 texels; higher ones change the factor by a few percent at most. Their
///   overlap is what a stencil reads; each texel is written in one block. Lines run through the
///   whole texture, not chart by chart: inside, charts do not couple.
/// - The origin of every chart's grids is texel (0, 0) of its texture.
/// - Where charts are not much larger than coarse texels, coarse functions depend on one another,
///   and whether a factorisation fails is up to rounding. The diagonals of factored coarse matrices
///   are raised by a trace of themselves, which determines what means nothing. Null spaces are held
///   at one unknown.

#include "mq/baseline/reference_cycle.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/grid_levels.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/galerkin.h"

namespace mq {

namespace {

/// Of factored coarse diagonals, see above: rounding / raise must stay small.
template <class Real>
constexpr double raise = sizeof(Real) == 8 ? 1e-12 : 1e-8;

constexpr double singular_below = 1e-14;  // of the trace: what rounding leaves of Σ A_ij, A·1 = 0

/// 1 for the first row of every singular component all of whose unknowns of a level are among
/// `rows`.
std::vector<char> pins(const std::vector<int>& rows, const NullSpace& null_space,
                       const std::vector<int>& component) {
  std::vector<int> missing(null_space.singular.size(), 0);
  for (const int c : component) ++missing[c];
  for (const int k : rows) --missing[component[k]];
  std::vector<char> pinned(rows.size(), 0);
  for (std::size_t p = 0; p < rows.size(); ++p) {
    const int c = component[rows[p]];
    if (!null_space.singular[c] || missing[c] != 0) continue;
    pinned[p] = 1;
    missing[c] = -1;
  }
  return pinned;
}

/// A with a diagonal that a factorisation can live with. A row that is all zero (a texel alone,
/// without mass) becomes the identity's.
SparseMatrix definite(SparseMatrix A, const std::vector<char>& pinned, double raised) {
  for (int row = 0; row < A.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
      if (entry.col() == row) {
        double& value = entry.valueRef();
        value = value > 0 ? value * (pinned[row] ? 2 : 1 + raised) : 1;
      }
  return A;
}

void factor(const SparseMatrix& A, const std::vector<char>& pinned, double raised,
            std::optional<DirectSolver>& solver) {
  if (A.rows() == 0) return;
  const SparseMatrix matrix = definite(A, pinned, raised);
  if (solver)
    solver->refactor(matrix);
  else
    solver.emplace(matrix);
}

/// Components of a coarse level: those of the texels it serves.
std::vector<int> coarse_components(const LevelTransfer& P, const std::vector<int>& fine) {
  std::vector<int> coarse(P.coarse_rows());
  std::array<WeightedIndex, 4> parents;
  for (int i = 0; i < P.fine_rows(); ++i) {
    const int count = P.parents(i, parents);
    for (int p = 0; p < count; ++p) coarse[parents[p].index] = fine[i];
  }
  return coarse;
}

void check_finite(const SparseMatrix& A) {
  parallel_for(A.rows(), [&](std::int64_t row) {
    double sum = 0, diagonal = 0;
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
      sum += std::abs(entry.value());
      if (entry.col() == row) diagonal = entry.value();
    }
    require(std::isfinite(sum),
            fmt::format("the matrix holds a value that is not finite in row {}", row));
    if (!(diagonal > 0) && sum > 0)
      throw NotPositiveDefinite(fmt::format(
          "the matrix is not positive definite: its diagonal is {} in row {}", diagonal, row));
  });
}

}  // namespace

StencilBlocks make_blocks(const StencilLayout& layout, const Texels& texels, int block_height) {
  // Even lines, then odd ones; block, row and column in each.
  const auto line_of = [&](const StencilRun& run) {
    const Texels::Place& p = texels.places[run.first];
    const int line = p.y / block_height;
    return std::tuple(line % 2, p.texture, line);
  };
  const auto block_of = [&](const StencilRun& run) {
    return texels.places[run.first].x / StencilLayout::max_run;
  };
  const auto row_of_run = [&](const StencilRun& run) { return texels.places[run.first].y; };
  StencilBlocks result;
  result.segments = layout.runs;
  std::sort(result.segments.begin(), result.segments.end(),
            [&](const StencilRun& a, const StencilRun& b) {
              return std::tuple(line_of(a), block_of(a), row_of_run(a), a.first) <
                     std::tuple(line_of(b), block_of(b), row_of_run(b), b.first);
            });
  for (int s = 0; s < int(result.segments.size()); ++s) {
    const StencilRun& run = result.segments[s];
    const StencilRun* last = s > 0 ? &result.segments[s - 1] : nullptr;
    const bool new_line = !last || line_of(*last) != line_of(run);
    const bool new_block = new_line || block_of(*last) != block_of(run);
    const bool new_row = new_block || row_of_run(*last) != row_of_run(run);
    if (new_line) result.lines.push_back(int(result.blocks.size()));
    if (new_block) result.blocks.push_back(int(result.rows.size()));
    if (new_row) result.rows.push_back(s);
    if (new_line && std::get<0>(line_of(run)) == 0) ++result.even_lines;
  }
  result.lines.push_back(int(result.blocks.size()));
  result.blocks.push_back(int(result.rows.size()));
  result.rows.push_back(int(result.segments.size()));
  return result;
}

NullSpace::NullSpace(const SparseMatrix& A) : component(connected_components(A)) {
  const Vector row_sums = A * Vector::Ones(A.cols());
  const Signal sum = component_sums(component, row_sums);
  const Signal trace = component_sums(component, Vector(A.diagonal()));
  for (Eigen::Index c = 0; c < sum.rows(); ++c)
    singular.push_back(std::abs(sum(c, 0)) <= singular_below * trace(c, 0));
}

bool NullSpace::empty() const {
  return std::find(singular.begin(), singular.end(), char(1)) == singular.end();
}

template <class Real>
ReferenceCycle<Real>::ReferenceCycle(const SparseMatrix& A, const Texels& texels,
                                     const ReferenceOptions& options, const Progress& progress)
    : options_(options), rows_(int(A.rows())), entries_(A.nonZeros()) {
  require(
      A.rows() == A.cols() && A.rows() == texels.size() && A.isCompressed(),
      fmt::format("a compressed matrix of {0} × {0} was wanted for {0} texels, one of {1} × {2} "
                  "was given",
                  texels.size(), A.rows(), A.cols()));
  require(options.grids >= 2 && options.sweeps >= 0 && options.block_height >= 1,
          "the reference solver needs two grids or more and blocks of at least one row");
  if (rows_ == 0) return;
  check_finite(A);
  null_space_ = NullSpace(A);
  const SparseMatrix* matrix = &A;
  SparseMatrix coarse_matrix;
  Texels coarse_texels;
  const Texels* grid = &texels;
  std::vector<int> component = null_space_.component;
  for (int l = 0; l + 1 < options.grids; ++l) {
    StencilLayout layout = make_layout(*matrix, *grid);
    Level level;
    level.interior = InteriorRelaxation<Real>(make_blocks(layout, *grid, options.block_height));
    level.boundary_pins = pins(layout.irregular, null_space_, component);
    level.boundary = BoundaryRows<Real>(*matrix, std::move(layout.irregular));
    take_values(*matrix, level, l == 0 ? 0 : raise<Real>);

    int charts = 0;
    for (const int c : grid->chart) charts = std::max(charts, c + 1);
    GridCoarsening coarser = coarsen_grid(*grid, std::vector<GridStep>(charts));
    level.interpolation = Interpolation<Real>(*coarser.transfer);
    level.transfer = std::move(coarser.transfer);
    component = coarse_components(*level.transfer, component);
    coarse_matrix = galerkin(*matrix, *level.transfer, progress);
    coarse_texels = std::move(coarser.coarse);
    matrix = &coarse_matrix;
    grid = &coarse_texels;
    levels_.push_back(std::move(level));
    progress.at(double(l + 1) / options.grids);
  }
  coarsest_rows_ = int(matrix->rows());
  std::vector<int> all(coarsest_rows_);
  for (int k = 0; k < coarsest_rows_; ++k) all[k] = k;
  coarsest_pins_ = pins(all, null_space_, component);
  take_coarsest_values(*matrix);
  progress.at(1);
}

template <class Real>
void ReferenceCycle<Real>::set_values(const SparseMatrix& A, const Progress& progress) {
  require(A.rows() == rows_ && A.cols() == rows_ && A.nonZeros() == entries_ && A.isCompressed(),
          fmt::format("a matrix of the pattern the solver was made for ({} rows, {} entries) was "
                      "wanted, one of {} rows and {} entries was given; make another solver for it",
                      rows_, entries_, A.rows(), A.nonZeros()));
  if (rows_ == 0) return;
  check_finite(A);
  SparseMatrix coarse;
  const SparseMatrix* matrix = &A;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    take_values(*matrix, levels_[l], l == 0 ? 0 : raise<Real>);
    coarse = galerkin(*matrix, *levels_[l].transfer, progress);
    matrix = &coarse;
    progress.at(double(l + 1) / options_.grids);
  }
  take_coarsest_values(*matrix);
}

template <class Real>
void ReferenceCycle<Real>::take_values(const SparseMatrix& A, Level& level, double raised) {
  level.interior.set_values(A);
  level.boundary.set_values(A);
  factor(level.boundary.block(A), level.boundary_pins, raised, level.boundary_solver);
}

template <class Real>
void ReferenceCycle<Real>::take_coarsest_values(const SparseMatrix& A) {
  factor(A, coarsest_pins_, raise<Real>, coarsest_solver_);
}

template <class Real>
ReferenceCycle<Real>::Workspace::Workspace(const ReferenceCycle& cycle, int lanes, int channels)
    : levels_(cycle.levels_.size() + 1), lanes_(lanes), channels_(channels) {
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const bool last = l == cycle.levels_.size();
    const std::size_t size =
        std::size_t(l == 0 ? cycle.rows_ : cycle.levels_[l - 1].transfer->coarse_rows()) * lanes;
    if (l > 0) {
      levels_[l].b.resize(size);
      levels_[l].x.resize(size);
    }
    if (!last) levels_[l].r.resize(size);
  }
}

template <class Real>
void ReferenceCycle<Real>::solve_boundary(const Level& level, const Real* b, Real* x,
                                          const Workspace& workspace) const {
  if (!level.boundary_solver) return;
  const int lanes = workspace.lanes_, channels = workspace.channels_;
  const Signal X = level.boundary_solver->solve(
      level.boundary.interior_relative_residual(lanes, channels, b, x));
  const std::vector<int>& boundary = level.boundary.boundary();
  for (Eigen::Index p = 0; p < X.rows(); ++p)
    for (int c = 0; c < channels; ++c) x[std::int64_t(boundary[p]) * lanes + c] = Real(X(p, c));
}

template <class Real>
void ReferenceCycle<Real>::solve_coarsest(const Real* b, Real* x,
                                          const Workspace& workspace) const {
  const int lanes = workspace.lanes_, channels = workspace.channels_;
  Signal B(coarsest_rows_, channels);
  for (Eigen::Index k = 0; k < B.rows(); ++k)
    for (int c = 0; c < channels; ++c) B(k, c) = double(b[k * lanes + c]);
  const Signal X = coarsest_solver_->solve(B);
  for (Eigen::Index k = 0; k < X.rows(); ++k)
    for (int c = 0; c < channels; ++c) x[k * lanes + c] = Real(X(k, c));
}

template <class Real>
void ReferenceCycle<Real>::descend(std::size_t l, const Real* b, Real* x,
                                   Workspace& workspace) const {
  if (l == levels_.size()) {
    solve_coarsest(b, x, workspace);
    return;
  }
  const Level& level = levels_[l];
  const int lanes = workspace.lanes_;
  level.interior.relax(lanes, b, x, options_.sweeps);
  solve_boundary(level, b, x, workspace);

  std::vector<Real>& r = workspace.levels_[l].r;
  level.interior.residual(lanes, b, x, r.data());
  level.boundary.residual(lanes, b, x, r.data());
  typename Workspace::Vectors& below = workspace.levels_[l + 1];
  level.interpolation.restrict_to(lanes, r.data(), below.b.data());
  std::fill(below.x.begin(), below.x.end(), Real(0));
  descend(l + 1, below.b.data(), below.x.data(), workspace);
  level.interpolation.prolongate_add(lanes, below.x.data(), x);

  solve_boundary(level, b, x, workspace);
  level.interior.relax(lanes, b, x, options_.sweeps);
}

template <class Real>
void ReferenceCycle<Real>::cycle(const Real* b, Real* x, Workspace& workspace) const {
  if (rows_ > 0) descend(0, b, x, workspace);
}

template <class Real>
void ReferenceCycle<Real>::residual(int lanes, const Real* b, const Real* x, Real* r) const {
  levels_.front().interior.residual(lanes, b, x, r);
  levels_.front().boundary.residual(lanes, b, x, r);
}

template <class Real>
std::int64_t ReferenceCycle<Real>::bytes() const {
  std::int64_t sum = coarsest_solver_ ? 8 * coarsest_solver_->factor_nonzeros() : 0;
  for (const Level& level : levels_)
    sum += level.interior.bytes() + level.boundary.bytes() + level.interpolation.bytes() +
           level.transfer->bytes() +
           (level.boundary_solver ? 8 * level.boundary_solver->factor_nonzeros() : 0);
  return sum;
}

template class ReferenceCycle<float>;
template class ReferenceCycle<double>;

}  // namespace mq
