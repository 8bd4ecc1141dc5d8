// Parts of a chart that are neighbours in its texture and not on the surface.

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/fem/detail/node_position.h"
#include "mq/fem/grid_levels.h"

namespace mq {

namespace {

/// Per texel how far its neighbours are along the axis where they are farther, on the nearer side,
/// as the other may be of another sheet; of one without a stencil the largest of those that it
/// couples to, else the mean of its chart, 0 where no texel of that has one.
std::vector<float> widths(const SparseMatrix& A, const Texels& texels,
                          const StencilLayout& layout) {
  std::vector<float> width(std::size_t(texels.size()), 0.0F);
  parallel_for(
      std::ssize(layout.runs),
      [&](std::int64_t r) {
        const StencilRun& run = layout.runs[r];
        for (int i = 0; i < run.count; ++i) {
          const int k = run.first + i;
          const auto nearer = [&](int a, int b) {
            return std::min(texels.squared_distance(k, a), texels.squared_distance(k, b));
          };
          width[k] = float(std::sqrt(std::max(nearer(k - 1, k + 1), nearer(run.up + i, run.down + i))));
        }
      },
      64);
  std::vector<double> sum(std::size_t(texels.chart_count()), 0), count(sum.size(), 0);
  for (int k = 0; k < texels.size(); ++k) {
    sum[texels.chart[k]] += width[k];
    count[texels.chart[k]] += width[k] > 0;
  }
  std::vector<float> around(layout.irregular.size(), 0.0F);
  parallel_for(std::ssize(around), [&](std::int64_t p) {
    const int k = layout.irregular[p], chart = texels.chart[k];
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      around[p] = std::max(around[p], width[entry.col()]);
    if (around[p] == 0 && count[chart] > 0) around[p] = float(sum[chart] / count[chart]);
  });
  for (std::size_t p = 0; p < around.size(); ++p) width[layout.irregular[p]] = around[p];
  return width;
}

/// Which of a node's texels are of one sheet, numbered from that of the first.
class InjectivePartFinder {
 public:
  InjectivePartFinder(const SparseMatrix& A, const Texels& texels, const StencilLayout& layout)
      : A_(A), texels_(texels), irregular_(std::size_t(layout.rows), 0), width_(widths(A, texels, layout)) {
    for (const int k : layout.irregular) irregular_[k] = 1;
  }

  int find(const std::vector<WeightedIndex>& children, std::vector<int>& sheet) const {
    sheet.assign(children.size(), -1);
    int count = 0;
    std::vector<std::size_t> stack;
    for (std::size_t seed = 0; seed < children.size(); ++seed) {
      if (sheet[seed] >= 0) continue;
      sheet[seed] = count;
      stack.push_back(seed);
      while (!stack.empty()) {
        const std::size_t a = stack.back();
        stack.pop_back();
        for (std::size_t b = 0; b < children.size(); ++b)
          if (sheet[b] < 0 && touch(children[a].index, children[b].index)) {
            sheet[b] = count;
            stack.push_back(b);
          }
      }
      ++count;
    }
    return count;
  }

  /// Whether two texels that A couples are of one sheet.
  bool near(int a, int b) const {
    const double width = std::max(width_[a], width_[b]);
    return width == 0 || texels_.distance(a, b) < far * width;
  }

 private:
  static constexpr double far =
      6;  // times the width: diagonal neighbours of a sheet that turns are nearer

  bool touch(int a, int b) const { return couple(a, b) && near(a, b); }

  /// Stencils couple to the 3 × 3 texels around theirs, in the interior of a texture.
  bool couple(int a, int b) const {
    if (!irregular_[a] || !irregular_[b]) {
      const Texels::Place &p = texels_.places[a], &q = texels_.places[b];
      return p.texture == q.texture && std::abs(p.x - q.x) <= 1 && std::abs(p.y - q.y) <= 1;
    }
    const int* begin = A_.innerIndexPtr() + A_.outerIndexPtr()[a];
    const int* end = A_.innerIndexPtr() + A_.outerIndexPtr()[a + 1];
    return std::binary_search(begin, end, b);
  }

  const SparseMatrix& A_;
  const Texels& texels_;
  std::vector<char> irregular_;
  std::vector<float> width_;
};

}  // namespace

std::vector<int> find_contacts(const SparseMatrix& A, const Texels& texels,
                               const StencilLayout& layout) {
  const InjectivePartFinder sheets(A, texels, layout);
  std::vector<char> contact(layout.irregular.size(), 0);
  parallel_for(std::ssize(contact), [&](std::int64_t p) {
    const int k = layout.irregular[p];
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      if (!sheets.near(k, int(entry.col()))) contact[p] = 1;
  });
  std::vector<int> contacts;
  for (std::size_t p = 0; p < contact.size(); ++p)
    if (contact[p]) contacts.push_back(layout.irregular[p]);
  return contacts;
}

void part_sheets(const SparseMatrix& A, const Texels& texels, const StencilLayout& layout,
                 GridCoarsening& coarsening) {
  GridTransfer& transfer = *coarsening.transfer;
  Texels& coarse = coarsening.coarse;
  // Nodes of which no texel is irregular lie inside one sheet.
  std::vector<char> near(std::size_t(coarse.size()), 0);
  std::array<WeightedIndex, 4> parents;
  for (const int k : layout.irregular)
    for (int i = transfer.parents(k, parents); i-- > 0;) near[parents[i].index] = 1;
  std::vector<int> nodes;
  for (int node = 0; node < coarse.size(); ++node)
    if (near[node]) nodes.push_back(node);

  // Per node and texel its sheet; 0, which keeps the node, is that of the first.
  constexpr int block = 256;
  const InjectivePartFinder sheets(A, texels, layout);
  std::vector<std::vector<GridTransfer::Move>> found(nodes.size() / block + 1);
  parallel_blocks(std::ssize(nodes), block, [&](std::int64_t begin, std::int64_t end) {
    std::vector<WeightedIndex> children;
    std::vector<int> sheet;
    for (std::int64_t n = begin; n < end; ++n) {
      children.clear();
      transfer.children(nodes[n], children);
      if (sheets.find(children, sheet) == 1) continue;
      for (std::size_t i = 0; i < children.size(); ++i)
        if (sheet[i] > 0) found[begin / block].push_back({children[i].index, nodes[n], sheet[i]});
    }
  });

  std::vector<GridTransfer::Move> moves;
  std::vector<int> changed;
  int last = coarse.size() - 1, end = coarse.size();
  for (const auto& list : found)
    for (GridTransfer::Move move : list) {
      if (changed.empty() || changed.back() != move.from) {
        changed.push_back(move.from);
        last = end - 1;
      }
      move.to += last;
      end = std::max(end, move.to + 1);
      moves.push_back(move);
    }
  if (moves.empty()) return;
  for (const GridTransfer::Move& move : moves)
    if (move.to == coarse.size()) {
      coarse.places.push_back(coarse.places[move.from]);
      coarse.chart.push_back(coarse.chart[move.from]);
      changed.push_back(move.to);
      coarse.positions.emplace_back();
    }
  transfer.move(std::move(moves), end - int(near.size()));
  std::vector<WeightedIndex> list;
  for (const int node : changed)
    coarse.positions[node] = node_position(texels, transfer, node, list);
}

}  // namespace mq
