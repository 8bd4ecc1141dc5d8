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

double stencil_anisotropy(const Stencil& row) {
  const auto [nw, n, ne, w, centre, e, sw, s, se] = row;
  const double corners = nw + ne + sw + se;
  const double xx = -(w + e + corners), yy = -(n + s + corners), xy = -(se + nw - ne - sw);
  const double mean = (xx + yy) / 2, radius = std::hypot((xx - yy) / 2, xy);
  return (mean + radius) / std::max(mean - radius, 0.02 * centre);
}

template <class Round>
void StencilMatrix::fill(const SparseMatrix& A, const StencilLayout& layout, const Round& round) {
  layout_ = &layout;
  for (auto& stream : values5_) stream.assign(std::size_t(layout.rows) + 2 * margin, 0.0f);
  const auto stream = [&](int i) { return values5_[i].data() + margin; };
  float *const c = stream(0), *const e = stream(1), *const sw = stream(2), *const s = stream(3),
        *const se = stream(4);

  std::vector<char> is_irregular(layout.rows, 0);
  for (const int k : layout.irregular) is_irregular[k] = 1;

  // Irregular and clustered rows: their off-diagonal entries.
  start_.assign(layout.listed_count() + 1, 0);
  for (int p = 0; p < layout.listed_count(); ++p) {
    const int k = layout.listed(p);
    int entries = 0;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) entries += entry.col() != k;
    start_[p + 1] = start_[p] + entries;
  }
  columns_.resize(start_.back());
  values_.resize(start_.back());
  parallel_for(layout.listed_count(), [&](std::int64_t p) {
    const int k = layout.listed(int(p));
    std::int64_t at = start_[p];
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      if (entry.col() == k) {
        c[k] = round(k, k, entry.value());
      } else {
        columns_[at] = int(entry.col());
        values_[at++] = round(k, entry.col(), entry.value());
      }
    }
  });

  // Stencil rows: their own five values, and those that irregular neighbours would hold.
  parallel_for(std::int64_t(layout.runs.size()), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[r];
    for (int i = 0; i < run.count; ++i) {
      const int k = run.first + i, u = run.up + i, d = run.down + i;
      const double* row = A.valuePtr() + A.outerIndexPtr()[k];
      c[k] = round(k, k, row[4]);
      e[k] = round(k, k + 1, row[5]);
      sw[k] = round(k, d - 1, row[6]);
      s[k] = round(k, d, row[7]);
      se[k] = round(k, d + 1, row[8]);
      if (is_irregular[u - 1]) se[u - 1] = round(k, u - 1, row[0]);
      if (is_irregular[u]) s[u] = round(k, u, row[1]);
      if (is_irregular[u + 1]) sw[u + 1] = round(k, u + 1, row[2]);
      if (is_irregular[k - 1]) e[k - 1] = round(k, k - 1, row[3]);
    }
  }, 64);
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

void StencilMatrix::find_anisotropic_runs() {
  const int tiles = int(layout_->tiles.size()) - 1;
  std::vector<char> found(layout_->runs.size(), 0);
  parallel_for(std::int64_t(layout_->runs.size()), [&](std::int64_t r) {
    const StencilRun& run = layout_->runs[r];
    int count = 0;
    for (int i = 0; i < run.count; ++i) count += stencil_anisotropy(stencil_of(*this, run, i)) > strong_anisotropy;
    found[r] = count >= std::min(run.count, few_unknowns);
  }, 64);
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
  parallel_for(A.rows(), [&](std::int64_t row) { check_row(A, int(row)); });
  fill(A, layout, [&](std::int64_t i, std::int64_t j, double value) {
    return float(scaling(i, j) * value * (i == j ? raised(scaling, i) : 1));
  });
  find_anisotropic_runs();
}

StencilMatrix StencilMatrix::remainder(const SparseMatrix& A, const StencilLayout& layout,
                                       const Scaling& scaling) {
  StencilMatrix result;
  result.fill(A, layout, [&](std::int64_t i, std::int64_t j, double value) {
    const double scaled = scaling(i, j) * value;
    return float(scaled - double(float(scaled * (i == j ? raised(scaling, i) : 1))));
  });
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

void StencilMatrix::keep_row_sums(const SparseMatrix& A, const Scaling& scaling) {
  row_sums_.resize(A.rows() + margin);
  parallel_for(A.rows(), [&](std::int64_t row) {
    double sum = 0;
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
      sum += scaling(row, entry.col()) * entry.value() *
             (entry.col() == row ? raised(scaling, row) : 1);
    row_sums_[row] = float(sum);
  });
}

std::int64_t StencilMatrix::bytes() const {
  std::int64_t sum = std::int64_t(row_sums_.size()) * sizeof(float);
  for (const auto& stream : values5_) sum += std::int64_t(stream.size()) * sizeof(float);
  return sum + std::int64_t(start_.size() * sizeof(start_[0])) +
         std::int64_t(columns_.size() * (sizeof(int) + sizeof(float)));
}

}  // namespace mq
