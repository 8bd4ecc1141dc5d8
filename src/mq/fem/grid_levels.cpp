#include "mq/fem/grid_levels.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr int tile_width = StencilLayout::max_run;
constexpr int tile_height = 64;

using Place = Texels::Place;

bool is_at(const Texels& texels, int k, const Place& from, int chart, int dx, int dy) {
  const Place& p = texels.places[k];
  return p.texture == from.texture && p.x == from.x + dx && p.y == from.y + dy &&
         (texels.chart[k] == chart || dx != 0 || dy != 0);
}

/// Whether row k couples to its 3 × 3 neighbours and nothing else.
bool is_stencil(const SparseMatrix& A, const Texels& texels, int k) {
  const int begin = A.outerIndexPtr()[k];
  if (A.outerIndexPtr()[k + 1] - begin != 9) return false;
  const int* column = A.innerIndexPtr() + begin;
  const Place& place = texels.places[k];
  for (int i = 0; i < 9; ++i)
    if (!is_at(texels, column[i], place, texels.chart[k], i % 3 - 1, i / 3 - 1)) return false;
  for (int i = 0; i < 9; i += 3)
    if (column[i + 1] != column[i] + 1 || column[i + 2] != column[i] + 2) return false;
  return true;
}

constexpr double least_anisotropy = 16;  // lengths 4 : 1
constexpr double least_stiffness = 10;   // times the diagonal value of a neighbour
constexpr int rings_around_stiff = 2;
constexpr int rows_per_hard = 50;

/// How hard a row is for relaxation, both from 1 on where it is.
struct Hardness {
  float anisotropy = 0;  ///< of a stencil
  float stiffness = 0;  ///< beside the softest stencil it couples to, as in a triangle of nearly no
                        ///< area, whose texels can only move as one

  float worse() const { return std::max(anisotropy, stiffness); }
};

std::vector<Hardness> find_hardness(const SparseMatrix& A, const std::vector<char>& stencil) {
  const int n = int(stencil.size());
  std::vector<double> diagonal(n);
  parallel_for(n, [&](std::int64_t k) {
    diagonal[k] = stencil[k] ? A.valuePtr()[A.outerIndexPtr()[k] + 4] : A.coeff(k, k);
  });
  std::vector<Hardness> hardness(n);
  parallel_for(n, [&](std::int64_t k) {
    double softest = diagonal[k];
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      if (stencil[entry.col()]) softest = std::min(softest, diagonal[entry.col()]);
    hardness[k].stiffness = float(diagonal[k] / (least_stiffness * softest));
    if (!stencil[k]) return;
    Stencil row;
    std::copy_n(A.valuePtr() + A.outerIndexPtr()[k], 9, row.begin());
    hardness[k].anisotropy = float(stencil_anisotropy(row) / least_anisotropy);
  });
  return hardness;
}

/// Above which hardness rows are clustered: 1, or more so that they are not too many.
float limit_of(const std::vector<Hardness>& hardness) {
  std::vector<float> hard;
  for (const Hardness& h : hardness)
    if (h.worse() > 1) hard.push_back(h.worse());
  const std::size_t most = hardness.size() / rows_per_hard;
  if (hard.size() <= most) return 1;
  const auto limit = hard.end() - std::ptrdiff_t(most) - 1;
  std::nth_element(hard.begin(), limit, hard.end());
  return *limit;
}

/// Marks what row k couples to, and what that couples to, `rings` times.
void mark_around(const SparseMatrix& A, int k, int rings, std::vector<char>& marked) {
  for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
    marked[entry.col()] = 1;
    if (rings > 1) mark_around(A, int(entry.col()), rings - 1, marked);
  }
}

/// The rows that `make_robust_layout` clusters.
std::vector<int> find_clustered(const SparseMatrix& A, const StencilLayout& layout) {
  const int n = layout.rows;
  std::vector<char> stencil(n, 1);
  for (const int k : layout.irregular) stencil[k] = 0;
  const std::vector<Hardness> hardness = find_hardness(A, stencil);
  const float limit = limit_of(hardness);
  std::vector<char> marked(n, 0);
  for (int k = 0; k < n; ++k) {
    if (hardness[k].worse() > limit) marked[k] = 1;
    if (hardness[k].stiffness > limit) mark_around(A, k, rings_around_stiff, marked);
  }
  std::vector<int> clustered;
  for (int k = 0; k < n; ++k)
    if (marked[k] && stencil[k]) clustered.push_back(k);
  return clustered;
}

/// The runs of stencil rows among rows begin … end − 1.
void find_runs(const SparseMatrix& A, const Texels& texels, int begin, int end,
               std::vector<StencilRun>& runs, std::vector<int>& irregular) {
  StencilRun run;
  const auto finish = [&] {
    if (run.count > 0) runs.push_back(run);
    run = {};
  };
  for (int k = begin; k < end; ++k) {
    if (!is_stencil(A, texels, k)) {
      finish();
      irregular.push_back(k);
      continue;
    }
    const int* column = A.innerIndexPtr() + A.outerIndexPtr()[k];
    const int up = column[1], down = column[7];
    const bool goes_on = run.count > 0 && run.first + run.count == k && run.up + run.count == up &&
                         run.down + run.count == down && texels.places[k].x % tile_width != 0;
    if (!goes_on) {
      finish();
      run = {k, 0, up, down};
    }
    ++run.count;
  }
  finish();
}

/// Tiles in the order in which they are relaxed: by colour, then by place.
auto tile_of(const Place& p) {
  const int x = p.x / tile_width, y = p.y / tile_height;
  return std::tuple(x % 2 + 2 * (y % 2), p.texture, y, x);
}

void sort_into_tiles(const Texels& texels, StencilLayout& layout) {
  const auto key = [&](const StencilRun& run) { return tile_of(texels.places[run.first]); };
  std::stable_sort(layout.runs.begin(), layout.runs.end(),
                   [&](const StencilRun& a, const StencilRun& b) { return key(a) < key(b); });
  layout.colours.assign(1, 0);
  int colour = 0;
  for (int r = 0; r < int(layout.runs.size()); ++r) {
    if (r > 0 && key(layout.runs[r]) == key(layout.runs[r - 1])) continue;
    for (; colour < std::get<0>(key(layout.runs[r])); ++colour)
      layout.colours.push_back(int(layout.tiles.size()));
    layout.tiles.push_back(r);
  }
  layout.colours.push_back(int(layout.tiles.size()));
  layout.tiles.push_back(int(layout.runs.size()));
}

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

/// The place of a node: that of its own texel, or the mean of those it serves.
std::array<float, 3> node_position(const Texels& fine, const GridTransfer& transfer, int node,
                                   std::vector<WeightedIndex>& children) {
  children.clear();
  transfer.children(node, children);
  std::array<double, 3> sum = {0, 0, 0};
  double total = 0;
  for (const WeightedIndex& c : children) {
    if (c.weight == 1) return fine.positions[c.index];
    for (int i = 0; i < 3; ++i) sum[i] += double(c.weight) * fine.positions[c.index][i];
    total += c.weight;
  }
  return {float(sum[0] / total), float(sum[1] / total), float(sum[2] / total)};
}

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
            return std::min(texels.distance(k, a), texels.distance(k, b));
          };
          width[k] = float(std::max(nearer(k - 1, k + 1), nearer(run.up + i, run.down + i)));
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
      : A_(A), texels_(texels), width_(widths(A, texels, layout)) {}

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

  bool touch(int a, int b) const {
    const int* begin = A_.innerIndexPtr() + A_.outerIndexPtr()[a];
    const int* end = A_.innerIndexPtr() + A_.outerIndexPtr()[a + 1];
    return std::binary_search(begin, end, b) && near(a, b);
  }

  const SparseMatrix& A_;
  const Texels& texels_;
  std::vector<float> width_;
};

}  // namespace

StencilLayout make_layout(const SparseMatrix& A, const Texels& texels) {
  StencilLayout layout;
  layout.rows = texels.size();
  constexpr int block = 1 << 16;
  const int blocks = (layout.rows + block - 1) / block;
  std::vector<std::vector<StencilRun>> runs(blocks);
  std::vector<std::vector<int>> irregular(blocks);
  parallel_blocks(layout.rows, block, [&](std::int64_t begin, std::int64_t end) {
    find_runs(A, texels, int(begin), int(end), runs[begin / block], irregular[begin / block]);
  });
  for (int b = 0; b < blocks; ++b) {
    layout.runs.insert(layout.runs.end(), runs[b].begin(), runs[b].end());
    layout.irregular.insert(layout.irregular.end(), irregular[b].begin(), irregular[b].end());
  }
  sort_into_tiles(texels, layout);
  return layout;
}

StencilLayout make_robust_layout(const SparseMatrix& A, const Texels& texels) {
  StencilLayout layout = make_layout(A, texels);
  layout.clustered = find_clustered(A, layout);
  return layout;
}

std::vector<GridStep> coarsening_steps(const Texels& texels, const StencilLayout& layout,
                                       double max_ratio) {
  const int charts = texels.chart_count();
  std::vector<double> along_x(charts, 0), along_y(charts, 0);
  for (const StencilRun& run : layout.runs) {
    const int chart = texels.chart[run.first];
    for (int i = 0; i < run.count; ++i) {
      along_x[chart] += texels.distance(run.first + i, run.first + i + 1);
      along_y[chart] += texels.distance(run.first + i, run.down + i);
    }
  }
  std::vector<GridStep> steps(charts);
  for (int c = 0; c < charts; ++c) {
    if (along_x[c] > max_ratio * along_y[c]) steps[c] = {1, 2};
    if (along_y[c] > max_ratio * along_x[c]) steps[c] = {2, 1};
  }
  return steps;
}

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
