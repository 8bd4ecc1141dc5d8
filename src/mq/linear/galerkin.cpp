/// (PᵀAP)_IJ = Σ_i P_iI Σ_j A_ij P_jJ, for one row I at a time: the children i of I, their
/// neighbours j and the parents J of those. A thread keeps an array that says where column J of
/// the row at hand is; rows are gathered in blocks, so that no row is computed twice.

#include "mq/linear/galerkin.h"

#include <algorithm>
#include <numeric>

#include <tbb/enumerable_thread_specific.h>

#include "mq/base/parallel.h"

namespace mq {

namespace {

struct Scratch {
  std::vector<int> place;  ///< per coarse column its position in the row, −1: none
  std::vector<int> columns;
  std::vector<double> values;
  std::vector<int> order;
  std::vector<WeightedIndex> children;
};

/// Consecutive rows of the product.
struct Block {
  std::vector<int> counts;
  std::vector<int> columns;
  std::vector<double> values;
};

void gather_row(const SparseMatrix& A, const LevelTransfer& P, int row, Scratch& s) {
  s.columns.clear();
  s.values.clear();
  s.children.clear();
  P.children(row, s.children);
  std::array<WeightedIndex, 4> parents;
  for (const WeightedIndex& child : s.children)
    for (SparseMatrix::InnerIterator entry(A, child.index); entry; ++entry) {
      const double value = double(child.weight) * entry.value();
      const int count = P.parents(int(entry.col()), parents);
      for (int p = 0; p < count; ++p) {
        int& place = s.place[parents[p].index];
        if (place < 0) {
          place = int(s.columns.size());
          s.columns.push_back(parents[p].index);
          s.values.push_back(0);
        }
        s.values[place] += value * double(parents[p].weight);
      }
    }
  for (const int column : s.columns) s.place[column] = -1;
}

void append_row(Scratch& s, Block& block) {
  s.order.resize(s.columns.size());
  std::iota(s.order.begin(), s.order.end(), 0);
  std::sort(s.order.begin(), s.order.end(),
            [&](int a, int b) { return s.columns[a] < s.columns[b]; });
  for (const int i : s.order) {
    block.columns.push_back(s.columns[i]);
    block.values.push_back(s.values[i]);
  }
  block.counts.push_back(int(s.columns.size()));
}

}  // namespace

SparseMatrix galerkin(const SparseMatrix& A, const LevelTransfer& P, const Progress& progress) {
  const int rows = P.coarse_rows();
  constexpr int block_rows = 4096;
  std::vector<Block> blocks((rows + block_rows - 1) / block_rows);
  tbb::enumerable_thread_specific<Scratch> scratch;
  parallel_blocks(rows, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    Scratch& s = scratch.local();
    s.place.resize(rows, -1);
    Block& block = blocks[begin / block_rows];
    const std::size_t usual = std::size_t(end - begin) * 9;  // a stencil; growing would double it
    block.columns.reserve(usual);
    block.values.reserve(usual);
    for (std::int64_t row = begin; row < end; ++row) {
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
