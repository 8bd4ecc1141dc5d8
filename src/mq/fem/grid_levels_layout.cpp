// Which rows are stencils, in which order they are relaxed, and which are too hard for that.

#include <algorithm>
#include <tuple>

#include "mq/base/parallel.h"
#include "mq/fem/grid_levels.h"

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

}  // namespace mq
