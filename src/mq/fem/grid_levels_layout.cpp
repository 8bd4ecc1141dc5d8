// Which rows are stencils, in which order they are relaxed, and which are too hard for that.

#include <algorithm>
#include <limits>
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

/// What row k − 1 is.
enum class Before { stencil, other };

/// Whether row k couples to its 3 × 3 neighbours and nothing else.
bool is_stencil(const SparseMatrix& A, const Texels& texels, int k, Before before) {
  const int begin = A.outerIndexPtr()[k];
  if (A.outerIndexPtr()[k + 1] - begin != 9) return false;
  const int* column = A.innerIndexPtr() + begin;
  for (int i = 0; i < 9; i += 3)
    if (column[i + 1] != column[i] + 1 || column[i + 2] != column[i] + 2) return false;
  // Beside a stencil whose columns are the ones before, the places of six are known.
  const bool known = before == Before::stencil && column[4] == k && column[0] == column[-9] + 1 &&
                     column[3] == column[-6] + 1 && column[6] == column[-3] + 1;
  const Place& place = texels.places[k];
  for (int i = known ? 2 : 0; i < 9; i += known ? 3 : 1)
    if (!is_at(texels, column[i], place, texels.chart[k], i % 3 - 1, i / 3 - 1)) return false;
  return true;
}

constexpr double least_anisotropy = 16;  // lengths 4 : 1
constexpr double least_stiffness = 10;   // times the diagonal value of a neighbour
constexpr int rings_around_stiff = 2;
constexpr int rows_per_hard = 50;

/// How hard a row is for relaxation, both from 1 on where it is.
struct Hardness {
  int row;
  float anisotropy;  ///< of a stencil
  float stiffness;   ///< beside the softest stencil it couples to, as in a triangle of nearly no
                     ///< area, whose texels can only move as one

  float worse() const { return std::max(anisotropy, stiffness); }
};

/// Diagonal values of stencil rows; infinity in the others.
std::vector<double> stencil_diagonal(const StencilRows& A, const StencilLayout& layout) {
  std::vector<double> diagonal(std::size_t(layout.rows), std::numeric_limits<double>::infinity());
  parallel_for(std::ssize(layout.runs), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[r];
    for (int k = run.first; k < run.first + run.count; ++k) diagonal[k] = A.at(k, Coupling::centre);
  }, 64);
  return diagonal;
}

/// Of the rows of a run those that are hard.
void add_hard_rows(const StencilRows& A, const StencilRun& run, const std::vector<double>& diagonal,
                   std::vector<Hardness>& hard) {
  const double *const up = diagonal.data() + run.up, *const here = diagonal.data() + run.first,
               *const down = diagonal.data() + run.down;
  const auto column = [&](int i) { return std::min({up[i], here[i], down[i]}); };
  double left = column(-1), middle = column(0);
  for (int i = 0; i < run.count; ++i) {
    const double right = column(i + 1), softest = std::min({left, middle, right});
    left = middle, middle = right;
    const Hardness found{run.first + i, float(stencil_anisotropy(A.stencil(run, i)) / least_anisotropy),
                         float(here[i] / (least_stiffness * softest))};
    if (found.worse() > 1) hard.push_back(found);
  }
}

/// The rows that are hard, stencils or not, in an order that does not depend on the number of threads.
std::vector<Hardness> find_hardness(const StencilRows& A, const StencilLayout& layout) {
  constexpr int block = 64;
  const std::vector<double> diagonal = stencil_diagonal(A, layout);
  const std::size_t blocks = layout.runs.size() / block + 1;
  std::vector<std::vector<Hardness>> found(blocks + layout.irregular.size() / block + 1);
  parallel_blocks(std::ssize(layout.runs), block, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r)
      add_hard_rows(A, layout.runs[r], diagonal, found[std::size_t(begin / block)]);
  });
  parallel_blocks(std::ssize(layout.irregular), block, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      const int k = layout.irregular[p];
      double own = 0, softest = std::numeric_limits<double>::infinity();
      for (SparseMatrix::InnerIterator entry(A.listed(), k); entry; ++entry) {
        if (entry.col() == k) own = entry.value();
        softest = std::min(softest, diagonal[entry.col()]);
      }
      const Hardness here{k, 0, float(own / (least_stiffness * std::min(softest, own)))};
      if (here.worse() > 1) found[blocks + std::size_t(begin / block)].push_back(here);
    }
  });
  std::vector<Hardness> hard;
  for (const auto& some : found) hard.insert(hard.end(), some.begin(), some.end());
  return hard;
}

/// Above which hardness rows are clustered: 1, or more so that of `rows` they are not too many.
float limit_of(const std::vector<Hardness>& hardness, int rows) {
  std::vector<float> hard;
  for (const Hardness& h : hardness) hard.push_back(h.worse());
  const std::size_t most = std::size_t(rows) / rows_per_hard;
  if (hard.size() <= most) return 1;
  const auto limit = hard.end() - std::ptrdiff_t(most) - 1;
  std::nth_element(hard.begin(), limit, hard.end());
  return *limit;
}

/// Marks what rows couple to, and what that couples to, and so on.
class RingMarker {
 public:
  RingMarker(const SparseMatrix& listed, const StencilLayout& layout)
      : listed_(listed), runs_(layout.runs), run_of_(runs_of_rows(layout)) {}

  void mark_around(int k, int rings, std::vector<char>& marked) const {
    const auto mark = [&](int neighbour) {
      marked[neighbour] = 1;
      if (rings > 1) mark_around(neighbour, rings - 1, marked);
    };
    if (run_of_[k] < 0) {
      for (SparseMatrix::InnerIterator entry(listed_, k); entry; ++entry) mark(int(entry.col()));
      return;
    }
    const StencilRun& run = runs_[run_of_[k]];
    for (const int neighbour : stencil_columns(run, k - run.first)) mark(neighbour);
  }

 private:
  const SparseMatrix& listed_;
  const std::vector<StencilRun>& runs_;
  std::vector<int> run_of_;
};

using Middles = std::array<int, 2>;
constexpr Middles no_stencil = {-1, -1};

/// The runs of stencil rows among rows begin … end − 1; middles(k, whether k − 1 is one) as in `make_layout`.
template <class OfRow>
void find_runs(const OfRow& middles, const Texels& texels, int begin, int end, std::vector<StencilRun>& runs,
               std::vector<int>& irregular) {
  StencilRun run;
  const auto finish = [&] {
    if (run.count > 0) runs.push_back(run);
    run = {};
  };
  for (int k = begin; k < end; ++k) {
    const auto [up, down] = middles(k, run.count > 0 ? Before::stencil : Before::other);
    if (up < 0) {
      finish();
      irregular.push_back(k);
      continue;
    }
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

template <class OfRow>
StencilLayout layout_of(const Texels& texels, const OfRow& middles) {
  StencilLayout layout;
  layout.rows = texels.size();
  constexpr int block = 1 << 16;
  const int blocks = (layout.rows + block - 1) / block;
  std::vector<std::vector<StencilRun>> runs(blocks);
  std::vector<std::vector<int>> irregular(blocks);
  parallel_blocks(layout.rows, block, [&](std::int64_t begin, std::int64_t end) {
    find_runs(middles, texels, int(begin), int(end), runs[begin / block], irregular[begin / block]);
  });
  for (int b = 0; b < blocks; ++b) {
    layout.runs.insert(layout.runs.end(), runs[b].begin(), runs[b].end());
    layout.irregular.insert(layout.irregular.end(), irregular[b].begin(), irregular[b].end());
  }
  sort_into_tiles(texels, layout);
  return layout;
}

}  // namespace

StencilLayout make_layout(const SparseMatrix& A, const Texels& texels) {
  return layout_of(texels, [&](int k, Before before) {
    if (!is_stencil(A, texels, k, before)) return no_stencil;
    const int* const columns = A.innerIndexPtr() + A.outerIndexPtr()[k];
    return Middles{columns[1], columns[7]};
  });
}

StencilLayout make_layout(const Texels& texels, const std::function<std::array<int, 2>(int k)>& middles) {
  return layout_of(texels, [&](int k, Before) { return middles(k); });
}

std::vector<int> find_clustered(const StencilRows& A, const StencilLayout& layout) {
  const std::vector<Hardness> hardness = find_hardness(A, layout);
  if (hardness.empty()) return {};
  const int n = layout.rows;
  const float limit = limit_of(hardness, n);
  std::vector<char> marked(n, 0);
  const RingMarker rings(A.listed(), layout);
  for (const Hardness& h : hardness) {
    if (h.worse() > limit) marked[h.row] = 1;
    if (h.stiffness > limit) rings.mark_around(h.row, rings_around_stiff, marked);
  }
  for (const int k : layout.irregular) marked[k] = 0;
  std::vector<int> clustered;
  for (int k = 0; k < n; ++k)
    if (marked[k]) clustered.push_back(k);
  return clustered;
}

StencilLayout make_robust_layout(const SparseMatrix& A, const Texels& texels) {
  StencilLayout layout = make_layout(A, texels);
  layout.clustered = find_clustered(StencilRows(A, layout), layout);
  return layout;
}

}  // namespace mq
