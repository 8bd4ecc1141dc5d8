#include "mq/linear/multigrid.h"

#include <cstring>

namespace mq {

CoarsestLevel::CoarsestLevel(SparseMatrix A, const std::vector<int>& component,
                             const std::vector<char>& singular)
    : rows_(int(A.rows())) {
  std::vector<char> pinned(singular.size(), 0);
  for (int row = 0; row < rows_; ++row) {
    const int c = component[row];
    const bool pin = singular[c] && !pinned[c];
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
      if (entry.col() == row) {
        // A row that is all zero (one texel without mass) is pinned too; rounding must not make a
        // redundant unknown of a tiny chart indefinite.
        // So must not what is left of a singular component that has come down to one row.
        double& value = entry.valueRef();
        const bool alone = A.outerIndexPtr()[row + 1] - A.outerIndexPtr()[row] == 1;
        value = value > 0 && !(pin && alone) ? value * (pin ? 2 : 1 + 1e-9) : 1;
      }
    if (pin) pinned[c] = 1;
  }
  if (rows_ == 0) return;
  // Where rounding leaves a dense factor no positive pivot, the sparse one says in which row.
  if (rows_ > most_dense_rows || !dense_.compute(Eigen::MatrixXd(A))) sparse_.emplace(A);
}

void CoarsestLevel::solve(int lanes, const float* b, float* x) const {
  if (rows_ == 0) return;
  Signal B(rows_, lanes);
  for (std::int64_t i = 0; i < B.size(); ++i) B.data()[i] = b[i];
  const Signal X = sparse_ ? sparse_->solve(B) : Signal(dense_.solve(Eigen::MatrixXd(B)));
  for (std::int64_t i = 0; i < X.size(); ++i) x[i] = float(X.data()[i]);
}

std::int64_t CoarsestLevel::bytes() const {
  return sparse_ ? 12 * sparse_->factor_nonzeros() : 8 * std::int64_t(rows_) * rows_;
}

Multigrid::Workspace::Workspace(const Multigrid& multigrid, int lanes) : lanes_(lanes) {
  levels_.resize(multigrid.levels.size() + 1);
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const bool last = l + 1 == levels_.size();
    const int rows = last ? multigrid.coarsest.rows() : multigrid.levels[l]->layout.rows;
    if (l > 0) {
      levels_[l].b = LaneVector(rows, lanes);
      levels_[l].x = LaneVector(rows, lanes);
    }
    if (!last) levels_[l].r = LaneVector(rows, lanes);
  }
}

int Multigrid::passes_over_patches(std::size_t level) const {
  constexpr double nearly_all = 2.0 / 3;
  const MultigridLevel& here = *levels[level];
  const bool mostly = double(here.layout.irregular.size()) > nearly_all * double(here.layout.rows);
  return here.patches.exact() && !mostly ? options.patch_passes : options.sweeps;
}

void rescale(const std::vector<WeightedIndex>& rows, int lanes, float* v, int power) {
  for (const WeightedIndex& row : rows)
    for (int lane = 0; lane < lanes; ++lane) {
      float& value = v[std::int64_t(row.index) * lanes + lane];
      value = power > 0 ? value * row.weight : value / row.weight;
    }
}

void Multigrid::descend(std::size_t level, Guess guess, const float* b, float* x,
                        Workspace& workspace) const {
  const int lanes = workspace.lanes_;
  if (level == levels.size()) {
    coarsest.solve(lanes, b, x);
    return;
  }
  const MultigridLevel& here = *levels[level];
  if (guess == Guess::zero) std::memset(x, 0, sizeof(float) * std::size_t(here.layout.rows) * lanes);
  here.matrix.relax_stencils(lanes, b, x, options.sweeps, Order::forward);
  const int passes = passes_over_patches(level);
  for (int i = 0; i < passes; ++i) here.patches.relax(here.matrix, lanes, b, x, Order::forward);

  float* r = workspace.levels_[level].r.data();
  Workspace::Vectors& below = workspace.levels_[level + 1];
  here.matrix.residual(lanes, b, x, r);
  rescale(here.rescaled, lanes, r, 1);
  here.transfer->restrict_to(lanes, r, below.b.data());
  descend(level + 1, Guess::zero, below.b.data(), below.x.data(), workspace);
  if (level + 1 == std::size_t(options.twice_from) && level + 1 < levels.size())
    descend(level + 1, Guess::given, below.b.data(), below.x.data(), workspace);
  rescale(here.rescaled, lanes, x, -1);
  here.transfer->prolongate_add(lanes, below.x.data(), x);
  rescale(here.rescaled, lanes, x, 1);

  for (int i = 0; i < passes; ++i) here.patches.relax(here.matrix, lanes, b, x, Order::backward);
  here.matrix.relax_stencils(lanes, b, x, options.sweeps, Order::backward);
}

void Multigrid::cycle(const float* b, float* x, Workspace& workspace) const {
  descend(0, Guess::zero, b, x, workspace);
}

std::int64_t Multigrid::bytes() const {
  std::int64_t sum = coarsest.bytes();
  for (const auto& level : levels)
    sum += level->matrix.bytes() + level->patches.bytes() + level->transfer->bytes();
  return sum;
}

}  // namespace mq
