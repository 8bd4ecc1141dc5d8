/// Stencil rows read, with k the unknown and u, d the one above and below it,
///
///     (A·x)_k = c_k x_k + e_{k−1} x_{k−1} + e_k x_{k+1} + se_{u−1} x_{u−1} + s_u x_u + sw_{u+1} x_{u+1}
///               + sw_k x_{d−1} + s_k x_d + se_k x_{d+1},
///
/// so that five values per unknown hold a symmetric matrix. In a row the even unknowns are replaced
/// and then the odd ones, neither of which depend on one another, a vector register at a time; what
/// does not depend on the row itself, `rest`, is computed once for both. A tile small enough for
/// the cache is relaxed several times before the next is touched. Runs where triangles are stretched
/// (in any direction, so that lines of texels would be no remedy) are then relaxed some times more, all
/// tiles once each time: tile after tile, waves along the edges between tiles would stay.

#include "mq/linear/stencil_matrix.h"

#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/solver.h"
#include "mq/linear/vector_lanes.h"

namespace mq {

namespace {

using Stencils = StencilMatrix::Streams;

/// c_k's row without its own row's unknowns, for `Texels` unknowns: b − (above) − (below).
template <int lanes, int Texels>
inline Floats<Texels * lanes> rest_of(const Stencils& A, const float* b, const float* x, int k, int u,
                                      int d) {
  constexpr int N = Texels * lanes;
  const auto value = [](const float* stream, int i) {
    return spread<Texels, lanes>(load<Texels>(stream + i));
  };
  const auto at = [&](int i) { return load<N>(x + std::int64_t(i) * lanes); };
  Floats<N> sum = load<N>(b + std::int64_t(k) * lanes);
  sum -= value(A.se, u - 1) * at(u - 1);
  sum -= value(A.s, u) * at(u);
  sum -= value(A.sw, u + 1) * at(u + 1);
  sum -= value(A.sw, k) * at(d - 1);
  sum -= value(A.s, k) * at(d);
  sum -= value(A.se, k) * at(d + 1);
  return sum;
}

/// What a row's unknowns become: (rest − west neighbours − east neighbours) / diagonal. Holds the
/// matrix values and `rest` of `Texels` unknowns.
template <int lanes, int Texels>
struct RowStep {
  using Pack = Floats<Texels * lanes>;
  Pack rest, west, east, inverse;

  RowStep(const Stencils& A, const float* b, const float* x, int k, int u, int d)
      : rest(rest_of<lanes, Texels>(A, b, x, k, u, d)),
        west(spread<Texels, lanes>(load<Texels>(A.e + k - 1))),
        east(spread<Texels, lanes>(load<Texels>(A.e + k))),
        inverse(spread<Texels, lanes>(1.0f / load<Texels>(A.c + k))) {}

  Pack operator()(Pack left, Pack right) const {
    return (rest - west * left - east * right) * inverse;
  }
};

/// All ones in the lanes of even (parity 0) or odd unknowns.
template <int lanes>
inline auto parity_mask(int parity) {
  typename FloatPack<register_floats>::Mask mask;
  for (int i = 0; i < register_floats; ++i) mask[i] = (i / lanes) % 2 == parity ? -1 : 0;
  return mask;
}

/// Replaces the unknowns of one parity from the `begin`th (an even one) of a run on, one at a time.
template <int lanes>
inline void relax_singly(const Stencils& A, const StencilRun& run, int begin, int parity,
                         const float* b, float* x) {
  for (int i = begin + parity; i < run.count; i += 2) {
    const int k = run.first + i;
    const RowStep<lanes, 1> step(A, b, x, k, run.up + i, run.down + i);
    float* at = x + std::int64_t(k) * lanes;
    store<lanes>(at, step(load<lanes>(at - lanes), load<lanes>(at + lanes)));
  }
}

/// Replaces the first `end` unknowns of a run, whole registers of them: those of parity `first`, and
/// one register behind them those of the other. Nothing is read that was just stored.
template <int lanes>
inline void relax_registers(const Stencils& A, const StencilRun& run, int end, int first,
                            const float* b, float* x) {
  constexpr int N = register_floats, wide = N / lanes;
  using Pack = Floats<N>;
  using Step = RowStep<lanes, wide>;
  const auto mask = parity_mask<lanes>(first);
  const auto at = [&](int i) { return x + std::int64_t(run.first + i) * lanes; };
  const auto step_at = [&](int i) {
    return Step(A, b, x, run.first + i, run.up + i, run.down + i);
  };
  const auto left_of = [](Pack left, Pack here) { return shifted<N - lanes>(left, here); };
  const auto right_of = [](Pack here, Pack right) { return shifted<lanes>(here, right); };
  const auto load_from = [&](int i) { return i < end ? load<N>(at(i)) : repeat<lanes>(at(i)); };

  Pack left = repeat<lanes>(at(-1)), here = load<N>(at(0)), right = load_from(wide);
  Step step = step_at(0);
  Pack half = mask ? step(left_of(left, here), right_of(here, right)) : here;
  for (int i = wide; i < end; i += wide) {
    const Step next_step = step_at(i);
    const Pack beyond = load_from(i + wide);
    const Pack next_half =
        mask ? next_step(left_of(here, right), right_of(right, beyond)) : right;
    left = mask ? half : step(left_of(left, half), right_of(half, next_half));
    store<N>(at(i - wide), left);
    here = right;
    right = beyond;
    half = next_half;
    step = next_step;
  }
  store<N>(at(end - wide), mask ? half : step(left_of(left, half), right_of(half, right)));
}

/// One sweep over a run: its even and then its odd unknowns, or backward the other way about.
template <int lanes, Order order>
inline void relax_run(const Stencils& A, const StencilRun& run, const float* b, float* x) {
  constexpr int first = order == Order::forward ? 0 : 1, wide = register_floats / lanes;
  const int end = wide > 1 ? run.count / wide * wide : 0;
  relax_singly<lanes>(A, run, end, first, b, x);
  if constexpr (wide > 1)
    if (end > 0) relax_registers<lanes>(A, run, end, first, b, x);
  relax_singly<lanes>(A, run, end, 1 - first, b, x);
}

template <int lanes, int Texels>
inline void residual_of_texels(const Stencils& A, const float* b, const float* x, float* r, int k, int u,
                        int d) {
  constexpr int N = Texels * lanes;
  const float* at = x + std::int64_t(k) * lanes;
  const auto value = [](const float* stream, int i) {
    return spread<Texels, lanes>(load<Texels>(stream + i));
  };
  Floats<N> sum = rest_of<lanes, Texels>(A, b, x, k, u, d);
  sum -= value(A.e, k - 1) * load<N>(at - lanes);
  sum -= value(A.c, k) * load<N>(at);
  sum -= value(A.e, k) * load<N>(at + lanes);
  store<N>(r + std::int64_t(k) * lanes, sum);
}

template <int lanes>
inline void residual_of_run(const Stencils& A, const StencilRun& run, const float* b,
                            const float* x, float* r) {
  constexpr int wide = register_floats / lanes;
  int i = 0;
  for (; i + wide <= run.count; i += wide)
    residual_of_texels<lanes, wide>(A, b, x, r, run.first + i, run.up + i, run.down + i);
  for (; i < run.count; ++i)
    residual_of_texels<lanes, 1>(A, b, x, r, run.first + i, run.up + i, run.down + i);
}

/// Sums of products in single precision, over no more than a run; `total` widens them.
template <int lanes, int N>
struct RunSums {
  Floats<N> with_product{}, with_r{};

  void add(Floats<N> x, Floats<N> product, Floats<N> r) {
    with_product += x * product;
    with_r += x * r;
  }
  void add_to(StencilMatrix::Products& total) const {
    for (int i = 0; i < N; ++i) {
      total.with_product[i % lanes] += value(with_product, i);
      total.with_r[i % lanes] += value(with_r, i);
    }
  }

 private:
  static double value(Floats<N> v, int i) {
    if constexpr (N == 1)
      return v;
    else
      return v[i];
  }
};

/// The vectors of a product: y = A·x, and r, by which x is multiplied.
struct ProductVectors {
  const float *x, *r;
  float* y;
};

template <int lanes, int Texels>
inline void product_at(const Stencils& A, const float* row_sums, const ProductVectors& v, int k,
                       int u, int d, RunSums<lanes, Texels * lanes>& sums) {
  constexpr int N = Texels * lanes;
  const auto at = [&](int i) { return load<N>(v.x + std::int64_t(i) * lanes); };
  const auto value = [](const float* stream, int i) {
    return spread<Texels, lanes>(load<Texels>(stream + i));
  };
  const Floats<N> own = at(k);
  Floats<N> sum = value(row_sums, k) * own;
  sum += value(A.se, u - 1) * (at(u - 1) - own);
  sum += value(A.s, u) * (at(u) - own);
  sum += value(A.sw, u + 1) * (at(u + 1) - own);
  sum += value(A.e, k - 1) * (at(k - 1) - own);
  sum += value(A.e, k) * (at(k + 1) - own);
  sum += value(A.sw, k) * (at(d - 1) - own);
  sum += value(A.s, k) * (at(d) - own);
  sum += value(A.se, k) * (at(d + 1) - own);
  const std::int64_t here = std::int64_t(k) * lanes;
  store<N>(v.y + here, sum);
  sums.add(own, sum, load<N>(v.r + here));
}

template <int lanes>
inline void product_of_run(const Stencils& A, const float* row_sums, const StencilRun& run,
                           const ProductVectors& v, StencilMatrix::Products& total) {
  constexpr int wide = register_floats / lanes;
  RunSums<lanes, register_floats> sums;
  RunSums<lanes, lanes> rest;
  int i = 0;
  for (; i + wide <= run.count; i += wide)
    product_at<lanes, wide>(A, row_sums, v, run.first + i, run.up + i, run.down + i, sums);
  for (; i < run.count; ++i)
    product_at<lanes, 1>(A, row_sums, v, run.first + i, run.up + i, run.down + i, rest);
  sums.add_to(total);
  rest.add_to(total);
}

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
template <int lanes>
void StencilMatrix::relax_tiles(const StencilTiles& tiles, const float* b, float* x, int sweeps,
                                Order order) const {
  const Stencils A = stencils();
  const auto relax_tile = [&](int tile) {
    const int begin = tiles.tiles[tile], end = tiles.tiles[tile + 1];
    for (int sweep = 0; sweep < sweeps; ++sweep)
      if (order == Order::forward)
        for (int r = begin; r < end; ++r)
          relax_run<lanes, Order::forward>(A, tiles.runs[r], b, x);
      else
        for (int r = end - 1; r >= begin; --r)
          relax_run<lanes, Order::backward>(A, tiles.runs[r], b, x);
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

template <int lanes>
void StencilMatrix::residual_of_runs(const StencilTiles& tiles, const float* b, const float* x,
                                     float* r) const {
  const Stencils A = stencils();
  parallel_for(std::int64_t(tiles.runs.size()), [&](std::int64_t i) {
    residual_of_run<lanes>(A, tiles.runs[i], b, x, r);
  }, 64);
}

template <int lanes>
void StencilMatrix::residual_at(int position, const float* b, const float* x, float* r) const {
  const Row row = listed_row(position);
  const std::int64_t k = layout_->irregular[position];
  Floats<lanes> sum = load<lanes>(b + k * lanes) - row.diagonal * load<lanes>(x + k * lanes);
  for (int i = 0; i < row.count; ++i)
    sum -= row.values[i] * load<lanes>(x + std::int64_t(row.columns[i]) * lanes);
  store<lanes>(r + k * lanes, sum);
}

template <int lanes>
StencilMatrix::Products StencilMatrix::multiply_by(const float* x, const float* r,
                                                   float* y) const {
  const Stencils A = stencils();
  const float* row_sums = row_sums_.data();
  const ProductVectors vectors{x, r, y};
  const auto of_stencils = [&](std::int64_t begin, std::int64_t end) {
    Products total;
    for (std::int64_t i = begin; i < end; ++i)
      product_of_run<lanes>(A, row_sums, layout_->runs[i], vectors, total);
    return total;
  };
  const auto of_irregular = [&](std::int64_t begin, std::int64_t end) {
    RunSums<lanes, lanes> sums;
    for (std::int64_t p = begin; p < end; ++p) {
      const Row row = listed_row(int(p));
      const std::int64_t k = layout_->irregular[p], here = k * lanes;
      const Floats<lanes> own = load<lanes>(x + here);
      Floats<lanes> sum = row_sums[k] * own;
      for (int i = 0; i < row.count; ++i)
        sum += row.values[i] * (load<lanes>(x + std::int64_t(row.columns[i]) * lanes) - own);
      store<lanes>(y + here, sum);
      sums.add(own, sum, load<lanes>(r + here));
    }
    Products total;
    sums.add_to(total);
    return total;
  };
  return parallel_sum(std::int64_t(layout_->runs.size()), Products{}, of_stencils, 64) +
         parallel_sum(std::int64_t(layout_->irregular.size()), Products{}, of_irregular, 128);
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

template <int lanes>
void StencilMatrix::relax_with(const StencilTiles& tiles, const StencilTiles& anisotropic,
                               const float* b, float* x, int sweeps, Order order) const {
  if (order == Order::forward) relax_tiles<lanes>(tiles, b, x, sweeps, order);
  for (int sweep = 0; sweep < anisotropic_sweeps * sweeps && !anisotropic.runs.empty(); ++sweep)
    relax_tiles<lanes>(anisotropic, b, x, 1, order);
  if (order == Order::backward) relax_tiles<lanes>(tiles, b, x, sweeps, order);
}

void StencilMatrix::relax_stencils(int lanes, const float* b, float* x, int sweeps,
                                   Order order) const {
  if (lanes == 1)
    relax_with<1>(*layout_, anisotropic_, b, x, sweeps, order);
  else
    relax_with<4>(*layout_, anisotropic_, b, x, sweeps, order);
}

void StencilMatrix::relax_stencils(const StencilPart& part, int lanes, const float* b, float* x,
                                   int sweeps, Order order) const {
  if (lanes == 1)
    relax_with<1>(part.stencils, part.anisotropic, b, x, sweeps, order);
  else
    relax_with<4>(part.stencils, part.anisotropic, b, x, sweeps, order);
}

void StencilMatrix::residual(int lanes, const float* b, const float* x, float* r) const {
  const auto of_lanes = [&]<int L>() {
    residual_of_runs<L>(*layout_, b, x, r);
    parallel_for(std::int64_t(layout_->irregular.size()),
                 [&](std::int64_t p) { residual_at<L>(int(p), b, x, r); });
  };
  lanes == 1 ? of_lanes.template operator()<1>() : of_lanes.template operator()<4>();
}

void StencilMatrix::residual(const StencilPart& part, int lanes, const float* b, const float* x,
                             float* r) const {
  const auto of_lanes = [&]<int L>() {
    residual_of_runs<L>(part.stencils, b, x, r);
    parallel_for(std::int64_t(part.irregular.size()),
                 [&](std::int64_t i) { residual_at<L>(part.irregular[i], b, x, r); });
  };
  lanes == 1 ? of_lanes.template operator()<1>() : of_lanes.template operator()<4>();
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
  return lanes == 1 ? multiply_by<1>(x, r, y) : multiply_by<4>(x, r, y);
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
