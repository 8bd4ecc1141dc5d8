/// Stencil rows read, with k the unknown and u, d the one above and below it,
///
///     (A·x)_k = c_k x_k + e_{k−1} x_{k−1} + e_k x_{k+1} + se_{u−1} x_{u−1} + s_u x_u + sw_{u+1} x_{u+1}
///               + sw_k x_{d−1} + s_k x_d + se_k x_{d+1},
///
/// so that five values per unknown hold a symmetric matrix. A tile small enough for
/// the cache is relaxed several times before the next is touched. Runs where triangles are stretched
/// (in any direction, so that lines of texels would be no remedy) are then relaxed some times more, all
/// tiles once each time: tile after tile, waves along the edges between tiles would stay.

#include "mq/linear/stencil_matrix.h"

#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/solver.h"

namespace mq {

namespace {

constexpr double strong_anisotropy = 6;  // lengths 2.4:1, from where a sweep halves little
constexpr int anisotropic_sweeps = 2;    // further ones per sweep, on runs ...
constexpr int few_unknowns = 4;          // ... with so many strongly anisotropic rows
constexpr int few_runs = 16;             // that are relaxed before other threads would have begun

Stencil stencil_of(const StencilMatrix& A, const StencilRun& run, int i) {
  const int k = run.first + i, u = run.up + i;
  return {A.south_east(u - 1), A.south(u), A.south_west(u + 1), A.east(k - 1),  A.centre(k),
          A.east(k),           A.south_west(k), A.south(k),      A.south_east(k)};
}

/// What the diagonal of row i is multiplied by.
double raised(const Scaling& scaling, std::int64_t i) {
  return scaling.row(i) == 1 ? 1 : 1 + StencilMatrix::raise;
}

/// What the entries of A are multiplied by where no row has a unit of its own.
struct CommonFactor {
  double common;

  double operator()(int, int) const { return common; }
  double raised(int) const { return 1; }
};

struct RowFactors {
  const Scaling& scaling;

  double operator()(int i, int j) const { return scaling(i, j); }
  double raised(int i) const { return mq::raised(scaling, i); }
};

/// Throws unless row `row` may be that of a positive semidefinite matrix.
void check_row(const SparseMatrix& A, int row) {
  double diagonal = 0, sum = 0;
  for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
    sum += std::abs(entry.value());
    if (entry.col() == row) diagonal = entry.value();
  }
  require(std::isfinite(sum), fmt::format("the matrix holds a value that is not finite in row {}", row));
  if (!(diagonal > 0) && sum > 0)
    throw NotPositiveDefinite(fmt::format(
        "the matrix is not positive definite: its diagonal is {} in row {}", diagonal, row));
}

}  // namespace

void StencilMatrix::make_room(const SparseMatrix& A, const StencilLayout& layout) {
  layout_ = &layout;
  for (auto& stream : values5_) stream.assign(std::size_t(layout.rows) + 2 * margin, 0.0f);
  start_.assign(std::size_t(layout.listed_count()) + 1, 0);
  for (int p = 0; p < layout.listed_count(); ++p) {
    const int k = layout.listed(p);
    int entries = 0;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) entries += entry.col() != k;
    start_[p + 1] = start_[p] + entries;
  }
  columns_.resize(std::size_t(start_.back()));
  values_.resize(columns_.size());
}

/// Irregular and clustered rows: their entries beside the diagonal, and the diagonal.
void StencilMatrix::fill_listed(const SparseMatrix& A, const Scaling& scaling, StencilMatrix* low) {
  parallel_for(layout_->listed_count(), [&](std::int64_t p) {
    const int k = layout_->listed(int(p));
    std::int64_t at = start_[p];
    double sum = 0, size = 0;
    bool positive = false;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      const bool own = entry.col() == k;
      const double scaled = scaling(k, entry.col()) * entry.value(), kept = own ? scaled * raised(scaling, k) : scaled;
      const auto high = float(kept);
      sum += kept;
      size += std::abs(kept);
      positive |= own && kept > 0;
      (own ? streams(0)[k] : values_[at]) = high;
      if (low) (own ? low->streams(0)[k] : low->values_[at]) = float(scaled - double(high));
      if (own) continue;
      columns_[at] = int(entry.col());
      if (low) low->columns_[at] = int(entry.col());
      ++at;
    }
    if (!positive || !std::isfinite(size)) check_row(A, k);
    if (low) row_sums_[k] = float(sum);
  });
}

/// The five values of a run's rows, and those that irregular neighbours would hold; factor(i, j) is what entry
/// (i, j) of A is multiplied by, and factor.raised(i) what a diagonal
/// value is multiplied by beyond that. Returns whether the run is anisotropic.
template <class Factor>
bool StencilMatrix::fill_run(const SparseMatrix& A, const Factor& factor, const StencilRun& run,
                             const char* irregular, StencilMatrix* low) {
  const bool alone = std::memchr(irregular + run.up - 1, 1, std::size_t(run.count) + 2) == nullptr;
  const auto set = [&](int stream, int k, double value, double kept) {
    const auto high = float(kept);
    streams(stream)[k] = high;
    if (low) low->streams(stream)[k] = float(value - double(high));
  };
  int strong = 0;
  const double* row = A.valuePtr() + A.outerIndexPtr()[run.first];
  for (int i = 0; i < run.count; ++i, row += 9) {
    const int k = run.first + i, u = run.up + i, d = run.down + i;
    const Stencil v = {factor(k, u - 1) * row[0], factor(k, u) * row[1],     factor(k, u + 1) * row[2],
                       factor(k, k - 1) * row[3], factor(k, k) * row[4],     factor(k, k + 1) * row[5],
                       factor(k, d - 1) * row[6], factor(k, d) * row[7],     factor(k, d + 1) * row[8]};
    const double centre = v[4] * factor.raised(k);
    double size = 0, sum = centre;
    for (int j = 0; j < 9; ++j) {
      size += std::abs(v[j]);
      if (j != 4) sum += v[j];
    }
    if (!(v[4] > 0) || !std::isfinite(size)) check_row(A, k);
    set(0, k, v[4], centre);
    set(1, k, v[5], v[5]);
    set(2, k, v[6], v[6]);
    set(3, k, v[7], v[7]);
    set(4, k, v[8], v[8]);
    if (low) row_sums_[k] = float(sum);
    strong += stencil_anisotropy(v) > strong_anisotropy;
    if (irregular[k - 1]) set(1, k - 1, v[3], v[3]);
    if (alone) continue;
    if (irregular[u - 1]) set(4, u - 1, v[0], v[0]);
    if (irregular[u]) set(3, u, v[1], v[1]);
    if (irregular[u + 1]) set(2, u + 1, v[2], v[2]);
  }
  return strong >= std::min(run.count, few_unknowns);
}

void StencilMatrix::fill(const SparseMatrix& A, const Scaling& scaling, StencilMatrix* low) {
  fill_listed(A, scaling, low);
  std::vector<char> irregular(std::size_t(layout_->rows), 0), found(layout_->runs.size(), 0);
  for (const int k : layout_->irregular) irregular[k] = 1;
  const auto fill_with = [&](const auto& factor) {
    parallel_for(std::ssize(found), [&](std::int64_t r) {
      found[r] = fill_run(A, factor, layout_->runs[r], irregular.data(), low);
    }, 64);
  };
  if (scaling.rows.empty())
    fill_with(CommonFactor{scaling.common});
  else
    fill_with(RowFactors{scaling});
  keep_anisotropic_runs(found);
}

/// Tile after tile `sweeps` times each, colour after colour; or that reversed.
void StencilMatrix::relax_tiles(const StencilTiles& tiles, int lanes, const float* b, float* x,
                                int sweeps, Order order) const {
  const Streams A = stencils();
  const auto relax = order == Order::forward ? stencil_kernels().relax_forward
                                             : stencil_kernels().relax_backward;
  const auto relax_tile = [&](int tile) {
    const int begin = tiles.tiles[tile], end = tiles.tiles[tile + 1];
    for (int sweep = 0; sweep < sweeps; ++sweep)
      relax(lanes, A, tiles.runs.data() + begin, end - begin, b, x);
  };
  const int count = int(tiles.colours.size()) - 1;
  for (int i = 0; i < count; ++i) {
    const int colour = order == Order::forward ? i : count - 1 - i;
    const int begin = tiles.colours[colour], end = tiles.colours[colour + 1];
    if (tiles.tiles[end] - tiles.tiles[begin] <= few_runs)
      for (int t = begin; t < end; ++t) relax_tile(t);
    else
      parallel_for(end - begin, [&](std::int64_t t) { relax_tile(begin + int(t)); }, 1);
  }
}

void StencilMatrix::keep_anisotropic_runs(const std::vector<char>& found) {
  const int tiles = int(layout_->tiles.size()) - 1;
  anisotropic_ = {{}, {0}, layout_->colours};
  for (int t = 0; t < tiles; ++t) {
    for (int r = layout_->tiles[t]; r < layout_->tiles[t + 1]; ++r)
      if (found[r]) anisotropic_.runs.push_back(layout_->runs[r]);
    anisotropic_.tiles.push_back(int(anisotropic_.runs.size()));
  }
}

void StencilMatrix::residual_of_runs(const StencilTiles& tiles, int lanes, const float* b,
                                     const float* x, float* r) const {
  const Streams A = stencils();
  parallel_blocks(std::int64_t(tiles.runs.size()), 64, [&](std::int64_t begin, std::int64_t end) {
    stencil_kernels().residual(lanes, A, tiles.runs.data() + begin, end - begin, b, x, r);
  });
}

StencilMatrix::StencilMatrix(const SparseMatrix& A, const StencilLayout& layout,
                             const Scaling& scaling) {
  make_room(A, layout);
  fill(A, scaling, nullptr);
}

StencilMatrix::Split StencilMatrix::split(const SparseMatrix& A, const StencilLayout& layout,
                                          const Scaling& scaling) {
  Split result;
  result.high.make_room(A, layout);
  result.low.make_room(A, layout);
  result.high.row_sums_.resize(std::size_t(A.rows()) + margin);
  result.high.fill(A, scaling, &result.low);
  return result;
}

void StencilMatrix::relax_with(const StencilTiles& tiles, const StencilTiles& anisotropic, int lanes,
                               const float* b, float* x, int sweeps, Order order) const {
  if (order == Order::forward) relax_tiles(tiles, lanes, b, x, sweeps, order);
  for (int sweep = 0; sweep < anisotropic_sweeps * sweeps && !anisotropic.runs.empty(); ++sweep)
    relax_tiles(anisotropic, lanes, b, x, 1, order);
  if (order == Order::backward) relax_tiles(tiles, lanes, b, x, sweeps, order);
}

void StencilMatrix::relax_stencils(int lanes, const float* b, float* x, int sweeps,
                                   Order order) const {
  relax_with(*layout_, anisotropic_, lanes, b, x, sweeps, order);
}

void StencilMatrix::relax_stencils(const StencilPart& part, int lanes, const float* b, float* x,
                                   int sweeps, Order order) const {
  relax_with(part.stencils, part.anisotropic, lanes, b, x, sweeps, order);
}

ListedRows StencilMatrix::listed_rows() const {
  return {layout_->irregular.data(), int(layout_->irregular.size()), layout_->clustered.data(),
          start_.data(),             columns_.data(),                values_.data(),
          centres(0)};
}

void StencilMatrix::residual(int lanes, const float* b, const float* x, float* r) const {
  residual_of_runs(*layout_, lanes, b, x, r);
  const ListedRows A = listed_rows();
  parallel_blocks(A.irregular_count, 1024, [&](std::int64_t begin, std::int64_t end) {
    stencil_kernels().residual_of_listed(lanes, A, {nullptr, begin, end}, b, x, r);
  });
}

void StencilMatrix::residual(const StencilPart& part, int lanes, const float* b, const float* x,
                             float* r) const {
  residual_of_runs(part.stencils, lanes, b, x, r);
  const ListedRows A = listed_rows();
  parallel_blocks(std::ssize(part.irregular), 1024, [&](std::int64_t begin, std::int64_t end) {
    stencil_kernels().residual_of_listed(lanes, A, {part.irregular.data(), begin, end}, b, x, r);
  });
}

double StencilMatrix::dominance() const {
  double worst = 0;
  const auto take = [&](double sum, double centre) {
    if (centre > 0) worst = std::max(worst, sum / centre);
  };
  for (const StencilRun& run : layout_->runs)
    for (int i = 0; i < run.count; ++i) {
      const Stencil row = stencil_of(*this, run, i);
      double sum = 0;
      for (int j = 0; j < 9; ++j)
        if (j != 4) sum += std::abs(row[j]);
      take(sum, row[4]);
    }
  for (int p = 0; p < int(layout_->irregular.size()); ++p) {
    const Row row = listed_row(p);
    double sum = 0;
    for (int i = 0; i < row.count; ++i) sum += std::abs(row.values[i]);
    take(sum, row.diagonal);
  }
  return worst;
}

StencilMatrix::Products StencilMatrix::multiply(int lanes, const float* x, const float* r,
                                                float* y) const {
  const Streams A = stencils();
  const ListedRows listed = listed_rows();
  const ProductVectors vectors{x, r, y};
  const auto of_stencils = [&](std::int64_t begin, std::int64_t end) {
    Products total;
    stencil_kernels().multiply(lanes, A, row_sums_.data(), layout_->runs.data() + begin, end - begin,
                               vectors, total);
    return total;
  };
  const auto of_irregular = [&](std::int64_t begin, std::int64_t end) {
    Products total;
    stencil_kernels().multiply_listed(lanes, listed, row_sums_.data(), {nullptr, begin, end}, vectors,
                                      total);
    return total;
  };
  return parallel_sum(std::int64_t(layout_->runs.size()), Products{}, of_stencils, 64) +
         parallel_sum(std::int64_t(layout_->irregular.size()), Products{}, of_irregular, 128);
}

std::int64_t StencilMatrix::bytes() const {
  std::int64_t sum = std::int64_t(row_sums_.size()) * sizeof(float);
  for (const auto& stream : values5_) sum += std::int64_t(stream.size()) * sizeof(float);
  return sum + std::int64_t(start_.size() * sizeof(start_[0])) +
         std::int64_t(columns_.size() * (sizeof(int) + sizeof(float)));
}

}  // namespace mq
