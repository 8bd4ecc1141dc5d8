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

/// Consecutive rows of the product.
struct Block {
  std::vector<int> counts;
  std::vector<int> columns;
  std::vector<double> values;
};

/// Σ_i P_iI A_ij over the children i: add(j, value).
template <class Add>
void for_each_neighbour(const SparseMatrix& A, std::span<const WeightedIndex> children, const Add& add) {
  const int *const starts = A.outerIndexPtr(), *const columns = A.innerIndexPtr();
  const double* const values = A.valuePtr();
  for (const WeightedIndex& child : children)
    for (int e = starts[child.index]; e < starts[child.index + 1]; ++e)
      add(columns[e], double(child.weight) * values[e]);
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

void sum_row(const SparseMatrix& A, const LevelTransfer& P, int row, Scratch& s) {
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
bool is_rounding(double sum, const SparseMatrix& A, std::span<const WeightedIndex> children) {
  constexpr double rounding = 1e-13;
  double absolute = 0;
  for_each_neighbour(A, children, [&](int, double value) { absolute += std::abs(value); });
  return std::abs(sum) <= rounding * absolute;
}

void gather_row(const SparseMatrix& A, const LevelTransfer& P, int row, Scratch& s) {
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

/// Whether the row `fine` of A is the 3 × 3 stencil around it: `up`, itself and `down` in the middle.
bool is_stencil(const SparseMatrix& A, int fine, int up, int down) {
  const int begin = A.outerIndexPtr()[fine];
  if (A.outerIndexPtr()[fine + 1] - begin != 9) return false;
  const int* columns = A.innerIndexPtr() + begin;
  const int middles[3] = {up, fine, down};
  for (int d = 0; d < 3; ++d)
    if (columns[3 * d] != middles[d] - 1 || columns[3 * d + 2] != middles[d] + 1) return false;
  return true;
}

/// What surrounds node `row` if the closed form holds for it: its children are 3 × 3 stencils, and all
/// 5 × 5 unknowns of these are interpolated between the 3 × 3 coarse nodes.
bool find_around(const SparseMatrix& A, const GridTransfer& P, int row, GridAround& around) {
  constexpr std::uint8_t all = 1 | 2 | 4 | 8;
  const GridChildren& children = P.grid_children(row);
  for (int b = 0; b < 3; ++b)
    if (children.flags[b] != all) return false;
  const auto third = [&](int fine, int triple) {
    const int begin = A.outerIndexPtr()[fine];
    return A.outerIndexPtr()[fine + 1] - begin == 9 ? A.innerIndexPtr()[begin + 3 * triple + 1] : -1;
  };
  int* const fine = around.fine;
  std::copy(children.centre, children.centre + 3, fine + 1);
  fine[0] = third(fine[1], 0), fine[4] = third(fine[3], 2);
  if (fine[0] < 0 || fine[4] < 0) return false;
  for (int b = 1; b < 4; ++b)
    for (int a = -1; a < 2; ++a)
      if (!is_stencil(A, fine[b] + a, fine[b - 1] + a, fine[b + 1] + a)) return false;
  int* const coarse = around.coarse;
  coarse[0] = int(P.grid_parents(fine[0]).upper), coarse[1] = row;
  coarse[2] = int(P.grid_parents(fine[4]).upper);
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
std::array<double, 9> grid_row(const SparseMatrix& A, const GridAround& around) {
  std::array<double, 9> sum{};
  for (int b = 0; b < 3; ++b)
    for (int a = 0; a < 3; ++a) {
      const double* stencil = A.valuePtr() + A.outerIndexPtr()[around.fine[b + 1] + a - 1];
      const auto &wide = grid_weights[a], &high = grid_weights[b];
      for (int d = 0; d < 3; ++d) {
        const double* of = stencil + 3 * d;
        double across[3];
        for (int U = 0; U < 3; ++U)
          across[U] = of[0] * wide[0][U] + of[1] * wide[1][U] + of[2] * wide[2][U];
        for (int V = 0; V < 3; ++V)
          for (int U = 0; U < 3; ++U) sum[3 * V + U] += high[d][V] * across[U];
      }
    }
  return sum;
}

void append_stencil(const GridAround& around, const std::array<double, 9>& values, Block& block) {
  for (const int middle : around.coarse)
    for (int u = -1; u < 2; ++u) block.columns.push_back(middle + u);
  block.values.insert(block.values.end(), values.begin(), values.end());
  block.counts.push_back(9);
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
  block.counts.push_back(int(s.row.columns.size()));
}

}  // namespace

SparseMatrix galerkin(const SparseMatrix& A, const LevelTransfer& P, const Progress& progress) {
  const int rows = P.coarse_rows();
  const GridTransfer* const grid = P.grid();
  constexpr int block_rows = 4096;
  std::vector<Block> blocks((rows + block_rows - 1) / block_rows);
  tbb::enumerable_thread_specific<Scratch> scratch;
  parallel_blocks(rows, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    Scratch& s = scratch.local();
    s.row.make_room(rows);
    Block& block = blocks[begin / block_rows];
    const std::size_t usual = std::size_t(end - begin) * 9;  // a stencil; growing would double it
    block.columns.reserve(usual);
    block.values.reserve(usual);
    GridAround around;
    for (std::int64_t row = begin; row < end; ++row) {
      if (grid && find_around(A, *grid, int(row), around)) {
        append_stencil(around, grid_row(A, around), block);
        continue;
      }
      gather_row(A, P, int(row), s);
      append_row(s, block);
    }
  });

  SparseMatrix C(rows, rows);
  int* outer = C.outerIndexPtr();
  outer[0] = 0;
  int row = 0;
  for (const Block& block : blocks)
    for (const int count : block.counts) {
      outer[row + 1] = outer[row] + count;
      ++row;
    }
  C.resizeNonZeros(outer[rows]);
  parallel_for(
      std::int64_t(blocks.size()),
      [&](std::int64_t b) {
        const int at = outer[b * block_rows];
        std::copy(blocks[b].columns.begin(), blocks[b].columns.end(), C.innerIndexPtr() + at);
        std::copy(blocks[b].values.begin(), blocks[b].values.end(), C.valuePtr() + at);
        blocks[b] = {};
      },
      1);
  return C;
}

}  // namespace mq
