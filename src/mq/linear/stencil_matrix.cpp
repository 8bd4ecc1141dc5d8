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

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/release.h"
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

/// What the diagonal of row i, which is no stencil, is multiplied by.
double raised(const Scaling& scaling, std::int64_t i) {
  return scaling.row(i) == 1 ? 1 : 1 + StencilMatrix::raise;
}

[[noreturn]] void refuse_diagonal(double value, std::int64_t row) {
  throw NotPositiveDefinite(
      fmt::format("the matrix is not positive definite: its diagonal is {} in row {}", value, row));
}

/// Throws unless row `row`, with this diagonal and sum of absolute values, may be that of a positive semidefinite matrix.
void check_row(double diagonal, double size, std::int64_t row) {
  require(std::isfinite(size), fmt::format("the matrix holds a value that is not finite in row {}", row));
  if (!(diagonal > 0) && size > 0) refuse_diagonal(diagonal, row);
}

}  // namespace

void StencilMatrix::make_room(const SparseMatrix& listed, const StencilLayout& layout) {
  layout_ = &layout;
  start_.assign(std::size_t(layout.listed_count()) + 1, 0);
  for (int p = 0; p < layout.listed_count(); ++p) {
    const int k = layout.listed(p);
    int entries = 0;
    for (SparseMatrix::InnerIterator entry(listed, k); entry; ++entry) entries += entry.col() != k;
    start_[p + 1] = start_[p] + entries;
  }
  columns_.resize(std::size_t(start_.back()));
  values_.resize(std::size_t(start_.back()));
}

/// Irregular and clustered rows: their entries beside the diagonal, and the diagonal.
void StencilMatrix::fill_listed(const SparseMatrix& listed, const Scaling& scaling, StencilMatrix* low) {
  parallel_for(layout_->listed_count(), [&](std::int64_t p) {
    const int k = layout_->listed(int(p));
    std::int64_t at = start_[p];
    double sum = 0, size = 0, diagonal = 0;
    for (SparseMatrix::InnerIterator entry(listed, k); entry; ++entry) {
      const bool own = entry.col() == k;
      const double scaled = scaling(k, entry.col()) * entry.value(), kept = own ? scaled * raised(scaling, k) : scaled;
      const auto high = float(kept);
      sum += kept;
      size += std::abs(kept);
      if (own) diagonal = entry.value();
      (own ? streams(0)[k] : values_[at]) = high;
      if (low) (own ? low->streams(0)[k] : low->values_[at]) = float(scaled - double(high));
      if (own) continue;
      columns_[at] = int(entry.col());
      ++at;
    }
    check_row(diagonal, size, k);
    if (low) row_sums_[k] = float(sum);
  });
}

namespace {

/// Multiplies what a run's rows have of neighbours with a unit of their own by that. These are no stencils, so that each
/// such value is of one stencil.
void scale_couplings(StencilRows& A, const StencilRun& run, const std::vector<float>& unit) {
  const auto scale = [&](int row, Coupling coupling, int neighbour) {
    if (unit[neighbour] != 1) A.at(row, coupling) *= unit[neighbour];
  };
  for (int i = 0; i < run.count; ++i) {
    const int k = run.first + i, up = run.up + i, down = run.down + i;
    scale(up - 1, Coupling::lower_right, up - 1), scale(up, Coupling::lower, up);
    scale(up + 1, Coupling::lower_left, up + 1), scale(k - 1, Coupling::right, k - 1);
    scale(k, Coupling::right, k + 1), scale(k, Coupling::lower_left, down - 1);
    scale(k, Coupling::lower, down), scale(k, Coupling::lower_right, down + 1);
  }
}

}  // namespace

/// Coupling by coupling, each of which is let go of when it has been rounded, so that the matrix is never held twice.
void StencilMatrix::fill(StencilRows& A, const Scaling& scaling, StencilMatrix* low) {
  std::vector<char> anisotropic(layout_->runs.size(), 0);
  parallel_for(std::ssize(anisotropic), [&](std::int64_t r) {
    const StencilRun& run = layout_->runs[r];
    if (!scaling.rows.empty()) scale_couplings(A, run, scaling.rows);
    int strong = 0;
    for (int i = 0; i < run.count; ++i) {
      const Stencil row = A.stencil(run, i);
      double size = 0, sum = 0;
      for (const double value : row) size += std::abs(value), sum += value;
      check_row(row[4], size, run.first + i);
      if (low) row_sums_[run.first + i] = float(scaling.common * sum);
      strong += stencil_anisotropy(row) > strong_anisotropy;
    }
    anisotropic[r] = strong >= std::min(run.count, few_unknowns);
  }, 64);
  keep_anisotropic_runs(anisotropic);

  for (int i = 0; i < 5; ++i) {
    const auto coupling = Coupling(i);
    values5_[i].resize(std::size_t(layout_->rows) + 2 * margin);
    if (low) low->values5_[i].resize(values5_[i].size());
    if (!A.has_stencils()) {
      for (StencilMatrix* matrix : {this, low})
        if (matrix) std::ranges::fill(matrix->values5_[i], 0.0F);
      continue;
    }
    parallel_blocks(layout_->rows + 2 * margin, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin - margin; k < end - margin; ++k) {
        const double value = scaling.common * A.at(int(k), coupling);
        streams(i)[k] = float(value);
        if (low) low->streams(i)[k] = float(value - double(float(value)));
      }
    });
    A.drop(coupling);
  }
  fill_listed(A.listed(), scaling, low);
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

StencilMatrix::StencilMatrix(StencilRows&& A, const StencilLayout& layout, const Scaling& scaling) {
  make_room(A.listed(), layout);
  fill(A, scaling, nullptr);
}

StencilMatrix::Split StencilMatrix::split(StencilRows&& A, const StencilLayout& layout, const Scaling& scaling) {
  Split result;
  result.high.make_room(A.listed(), layout);
  result.low.make_room(A.listed(), layout);
  release(result.low.columns_);
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
