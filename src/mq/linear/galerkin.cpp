/// (PᵀAP)_IJ = Σ_i P_iI Σ_j A_ij P_jJ, for one row I at a time: the children i of I, their
/// neighbours j and the parents J of those. A thread keeps an array that says where column J of
/// the row at hand is; rows are gathered in blocks, so that no row is computed twice.
///
/// Where a coarse node has 3 × 3 children in a grid, all of them with rows that are 3 × 3 stencils, its row
/// is one too, in closed form: a child in column a and row b of them, a, b ∈ {−1, 0, 1}, adds
/// Wᵇᵀ·A_ab·Wᵃ, A_ab its stencil as a matrix and Wᵃ_cU = w_a q_U(a + c), w = ½, 1, ½ and q_U(u) the linear
/// function of coarse node U at fine place u, 2U its own.

#include "mq/linear/galerkin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <tbb/enumerable_thread_specific.h>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// A sum of sparse rows.
struct SparseSum {
  std::vector<int> place;  ///< per column its position among those of the sum, −1: none
  std::vector<int> columns;
  std::vector<double> values;

  void make_room(int size) { place.resize(std::size_t(size), -1); }
  void add(int column, double value) {
    int& at = place[column];
    if (at < 0) {
      at = int(columns.size());
      columns.push_back(column);
      values.push_back(value);
    } else {
      values[at] += value;
    }
  }
  void clear() {
    for (const int column : columns) place[column] = -1;
    columns.clear();
    values.clear();
  }
};

struct Scratch {
  SparseSum row;   ///< the one at hand
  SparseSum fine;  ///< Σ_i P_iI A_ij by j, where the children of a row have many neighbours in common
  std::vector<std::uint64_t> order;
  std::vector<WeightedIndex> children;
};

/// Consecutive rows of the product: which have the closed form, and the entries of the others.
struct Block {
  std::vector<char> closed;
  std::vector<int> columns;
  std::vector<double> values;
};

/// The rows of a compressed matrix.
class CompressedRows {
 public:
  explicit CompressedRows(const SparseMatrix& A)
      : starts_(A.outerIndexPtr()), columns_(A.innerIndexPtr()), values_(A.valuePtr()) {}

  /// visit(column, value)
  template <class Visit>
  void for_each(int row, const Visit& visit) const {
    for (int e = starts_[row]; e < starts_[row + 1]; ++e) visit(columns_[e], values_[e]);
  }
  /// The unknowns above and below row `fine`, if it may be a stencil.
  bool find_column(int fine, int& up, int& down) const {
    if (starts_[fine + 1] - starts_[fine] != 9) return false;
    up = columns_[starts_[fine] + 1], down = columns_[starts_[fine] + 7];
    return true;
  }
  /// Whether the row `fine` is the 3 × 3 stencil around it: `up`, itself and `down` in the middle.
  bool is_stencil(int fine, int up, int down) const {
    if (starts_[fine + 1] - starts_[fine] != 9) return false;
    const int* const columns = columns_ + starts_[fine];
    const int middles[3] = {up, fine, down};
    for (int d = 0; d < 3; ++d)
      if (columns[3 * d] != middles[d] - 1 || columns[3 * d + 2] != middles[d] + 1) return false;
    return true;
  }
  Stencil stencil(int fine) const {
    Stencil values;
    std::copy_n(values_ + starts_[fine], 9, values.begin());
    return values;
  }

 private:
  const int *starts_, *columns_;
  const double* values_;
};

/// The rows of a matrix of stencils.
class RowsOfStencils {
 public:
  RowsOfStencils(const StencilRows& A, const StencilLayout& layout)
      : A_(A), listed_(A.listed()), runs_(layout.runs), run_of_(runs_of_rows(layout)) {}

  template <class Visit>
  void for_each(int row, const Visit& visit) const {
    if (run_of_[row] < 0) return listed_.for_each(row, visit);
    const std::array<int, 9> columns = stencil_columns(run(row), row - run(row).first);
    const Stencil values = stencil(row);
    for (int n = 0; n < 9; ++n) visit(columns[n], values[n]);
  }
  bool find_column(int fine, int& up, int& down) const {
    if (run_of_[fine] < 0) return false;
    const int i = fine - run(fine).first;
    up = run(fine).up + i, down = run(fine).down + i;
    return true;
  }
  bool is_stencil(int fine, int up, int down) const {
    int own_up = 0, own_down = 0;
    return find_column(fine, own_up, own_down) && own_up == up && own_down == down;
  }
  Stencil stencil(int fine) const { return A_.stencil(run(fine), fine - run(fine).first); }

 private:
  const StencilRun& run(int row) const { return runs_[run_of_[row]]; }

  const StencilRows& A_;
  CompressedRows listed_;
  const std::vector<StencilRun>& runs_;
  std::vector<int> run_of_;
};

/// Σ_i P_iI A_ij over the children i: add(j, value).
template <class Rows, class Add>
void for_each_neighbour(const Rows& A, std::span<const WeightedIndex> children, const Add& add) {
  for (const WeightedIndex& child : children)
    A.for_each(child.index, [&](int column, double value) { add(column, double(child.weight) * value); });
}

/// Adds value times row `fine` of P.
void add_parents(const LevelTransfer& P, int fine, double value, SparseSum& row) {
  std::array<WeightedIndex, 4> parents;
  const int count = P.parents(fine, parents);
  for (int p = 0; p < count; ++p) row.add(parents[p].index, value * double(parents[p].weight));
}

void add_parents(const GridTransfer& P, int fine, double value, SparseSum& row) {
  const GridParents& at = P.grid_parents(fine);
  if (at.moved) return add_parents(static_cast<const LevelTransfer&>(P), fine, value, row);
  const double share = value * (at.between_columns ? 0.5 : 1) * (at.between_rows ? 0.5 : 1);
  row.add(int(at.upper), share);
  if (at.between_columns) row.add(int(at.upper) + 1, share);
  if (!at.between_rows) return;
  row.add(at.lower, share);
  if (at.between_columns) row.add(at.lower + 1, share);
}

template <class Rows>
void sum_row(const Rows& A, const LevelTransfer& P, int row, Scratch& s) {
  s.row.clear();
  if (const SparseTransfer* const sparse = P.sparse()) {
    s.fine.make_room(P.fine_rows());
    s.fine.clear();
    for_each_neighbour(A, sparse->column(row), [&](int fine, double value) { s.fine.add(fine, value); });
    for (std::size_t k = 0; k < s.fine.columns.size(); ++k)
      for (const WeightedIndex& parent : sparse->row(s.fine.columns[k]))
        s.row.add(parent.index, s.fine.values[k] * double(parent.weight));
    return;
  }
  s.children.clear();
  P.children(row, s.children);
  const GridTransfer* const grid = P.grid();
  for_each_neighbour(A, s.children, [&](int fine, double value) {
    if (grid)
      add_parents(*grid, fine, value, s.row);
    else
      add_parents(P, fine, value, s.row);
  });
}

/// Whether the sum of all that children add is 0 but for rounding: of a component that has become one node, where A·1 = 0.
template <class Rows>
bool is_rounding(double sum, const Rows& A, std::span<const WeightedIndex> children) {
  constexpr double rounding = 1e-13;
  double absolute = 0;
  for_each_neighbour(A, children, [&](int, double value) { absolute += std::abs(value); });
  return std::abs(sum) <= rounding * absolute;
}

template <class Rows>
void gather_row(const Rows& A, const LevelTransfer& P, int row, Scratch& s) {
  sum_row(A, P, row, s);
  if (s.row.columns.size() != 1) return;
  const SparseTransfer* const sparse = P.sparse();
  double& only = s.row.values.front();
  if (is_rounding(only, A, sparse ? sparse->column(row) : std::span<const WeightedIndex>(s.children))) only = 0;
}

/// Wᵃ for a = −1, 0, 1, see above.
constexpr double grid_weights[3][3][3] = {{{0.5, 0, 0}, {0.25, 0.25, 0}, {0, 0.5, 0}},
                                          {{0.5, 0.5, 0}, {0, 1, 0}, {0, 0.5, 0.5}},
                                          {{0, 0.5, 0}, {0, 0.25, 0.25}, {0, 0, 0.5}}};

/// The fine unknowns and coarse nodes around a coarse node of a grid, row by row.
struct GridAround {
  int fine[5];    ///< those of its column
  int coarse[3];  ///< likewise
};

/// What surrounds node `row` if the closed form holds for it.
template <class Rows>
bool find_around(const Rows& A, const GridTransfer& P, int row, GridAround& around) {
  int unused = 0;
  std::copy_n(P.grid_children(row).centre, 3, around.fine + 1);
  if (!A.find_column(around.fine[1], around.fine[0], unused) || !A.find_column(around.fine[3], unused, around.fine[4]))
    return false;
  around.coarse[0] = int(P.grid_parents(around.fine[0]).upper), around.coarse[1] = row;
  around.coarse[2] = int(P.grid_parents(around.fine[4]).upper);
  return true;
}

/// Whether the closed form holds for node `row`: its children are 3 × 3 stencils, and all 5 × 5 unknowns of these are
/// interpolated between the 3 × 3 coarse nodes.
template <class Rows>
bool has_closed_form(const Rows& A, const GridTransfer& P, int row) {
  constexpr std::uint8_t all = 1 | 2 | 4 | 8;
  for (const std::uint8_t flags : P.grid_children(row).flags)
    if (flags != all) return false;
  GridAround around;
  if (!find_around(A, P, row, around)) return false;
  const int* const fine = around.fine;
  for (int b = 1; b < 4; ++b)
    for (int a = -1; a < 2; ++a)
      if (!A.is_stencil(fine[b] + a, fine[b - 1] + a, fine[b + 1] + a)) return false;
  const int* const coarse = around.coarse;
  if (coarse[0] + 1 >= coarse[1] - 1 || coarse[1] + 1 >= coarse[2] - 1) return false;
  for (int v = 0; v < 5; ++v)
    for (int u = -2; u < 3; ++u) {
      const GridParents& parents = P.grid_parents(fine[v] + u);
      const int left = u == -2 ? -1 : u == -1 ? -1 : u == 2 ? 1 : 0;
      if (parents.moved || parents.between_columns != unsigned(u & 1) ||
          parents.between_rows != unsigned(v & 1) || int(parents.upper) != coarse[v / 2] + left ||
          ((v & 1) && parents.lower != coarse[v / 2 + 1] + left))
        return false;
    }
  return true;
}

/// The closed form, row by row of the coarse stencil.
template <class Rows>
Stencil closed_form(const Rows& A, const GridAround& around) {
  Stencil sum{};
  for (int b = 0; b < 3; ++b)
    for (int a = 0; a < 3; ++a) {
      const Stencil stencil = A.stencil(around.fine[b + 1] + a - 1);
      const auto &wide = grid_weights[a], &high = grid_weights[b];
      for (int d = 0; d < 3; ++d) {
        const double* of = stencil.data() + 3 * d;
        double across[3];
        for (int U = 0; U < 3; ++U)
          across[U] = of[0] * wide[0][U] + of[1] * wide[1][U] + of[2] * wide[2][U];
        for (int V = 0; V < 3; ++V)
          for (int U = 0; U < 3; ++U) sum[3 * V + U] += high[d][V] * across[U];
      }
    }
  return sum;
}

template <class Rows>
void write_closed_form(const Rows& A, const GridTransfer& P, int row, int* columns, double* values) {
  GridAround around;
  find_around(A, P, row, around);
  for (const int middle : around.coarse)
    for (int u = -1; u < 2; ++u) *columns++ = middle + u;
  std::ranges::copy(closed_form(A, around), values);
}

void append_row(Scratch& s, Block& block) {
  s.order.clear();
  for (std::size_t i = 0; i < s.row.columns.size(); ++i)
    s.order.push_back(std::uint64_t(s.row.columns[i]) << 32 | i);
  std::ranges::sort(s.order);
  for (const std::uint64_t entry : s.order) {
    block.columns.push_back(int(entry >> 32));
    block.values.push_back(s.row.values[std::uint32_t(entry)]);
  }
}

/// First all rows but those in closed form, whose length is known, then these, in their place.
template <class Rows>
SparseMatrix product(const Rows& A, const LevelTransfer& P, const Progress& progress) {
  const int rows = P.coarse_rows();
  const GridTransfer* const grid = P.grid();
  constexpr int block_rows = 4096;
  constexpr int in_closed_form = 9;
  std::vector<Block> blocks((rows + block_rows - 1) / block_rows);
  tbb::enumerable_thread_specific<Scratch> scratch;
  SparseMatrix C(rows, rows);
  int* const starts = C.outerIndexPtr();
  parallel_blocks(rows, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    Scratch& s = scratch.local();
    s.row.make_room(rows);
    Block& block = blocks[begin / block_rows];
    block.closed.assign(std::size_t(end - begin), 0);
    for (std::int64_t row = begin; row < end; ++row) {
      const bool closed = grid && has_closed_form(A, *grid, int(row));
      block.closed[row - begin] = closed;
      if (!closed) {
        gather_row(A, P, int(row), s);
        append_row(s, block);
      }
      starts[row + 1] = closed ? in_closed_form : int(s.row.columns.size());
    }
  });
  starts[0] = 0;
  for (int row = 0; row < rows; ++row) starts[row + 1] += starts[row];
  C.resizeNonZeros(starts[rows]);
  parallel_blocks(rows, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    const Block block = std::move(blocks[begin / block_rows]);
    std::size_t next = 0;
    for (std::int64_t row = begin; row < end; ++row) {
      int* const columns = C.innerIndexPtr() + starts[row];
      double* const values = C.valuePtr() + starts[row];
      if (block.closed[row - begin]) {
        write_closed_form(A, *grid, int(row), columns, values);
        continue;
      }
      const auto count = std::size_t(starts[row + 1] - starts[row]);
      std::copy_n(block.columns.begin() + next, count, columns);
      std::copy_n(block.values.begin() + next, count, values);
      next += count;
    }
  });
  return C;
}

}  // namespace

SparseMatrix galerkin(const SparseMatrix& A, const LevelTransfer& P, const Progress& progress) {
  return product(CompressedRows(A), P, progress);
}

SparseMatrix galerkin(const StencilRows& A, const StencilLayout& layout, const LevelTransfer& P,
                      const Progress& progress) {
  return A.complete() ? product(CompressedRows(A.listed()), P, progress) : product(RowsOfStencils(A, layout), P, progress);
}

}  // namespace mq
