/// Stencil rows read, with k the unknown and u, d the one above and below it,
///
///     (A·x)_k = c_k x_k + e_{k−1} x_{k−1} + e_k x_{k+1} + se_{u−1} x_{u−1} + s_u x_u + sw_{u+1} x_{u+1}
///               + sw_k x_{d−1} + s_k x_d + se_k x_{d+1}.
///
/// In a row the even unknowns are replaced and then the odd ones, neither of which depend on one another,
/// a vector register at a time; what does not depend on the row itself, `rest`, is computed once for both.

#include "mq/linear/kernels/stencil_kernels.h"

#include "mq/linear/kernels/double_lanes.h"
#include "mq/linear/kernels/listed_rows.h"
#include "mq/linear/kernels/rounded.h"
#include "mq/linear/kernels/vector_lanes.h"

namespace mq::MARQUETRY_FORM {
namespace {

enum class Order { forward, backward };
using Stencils = StencilStreams;

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
  constexpr int N = pack_floats<lanes>, wide = pack_rows<lanes>;
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
  constexpr int first = order == Order::forward ? 0 : 1, wide = pack_rows<lanes>;
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
  constexpr int wide = pack_rows<lanes>;
  int i = 0;
  for (; i + wide <= run.count; i += wide)
    residual_of_texels<lanes, wide>(A, b, x, r, run.first + i, run.up + i, run.down + i);
  for (; i < run.count; ++i)
    residual_of_texels<lanes, 1>(A, b, x, r, run.first + i, run.up + i, run.down + i);
}

/// Sums of products in single precision, over no more than a run; `add_to` widens them.
template <int lanes, int N>
struct RunSums {
  Floats<N> with_product{}, with_r{};

  void add(Floats<N> x, Floats<N> product, Floats<N> r) {
    with_product += x * product;
    with_r += x * r;
  }
  void add_to(ProductSums& total) const {
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

template <int lanes, int Texels>
inline void product_at(const Stencils& A, const float* row_sums, const ProductVectors& v, int k,
                       int u, int d, RunSums<lanes, Texels * lanes>& sums) {
  constexpr int N = Texels * lanes;
  const auto at = [&](int i) { return load<N>(v.x + std::int64_t(i) * lanes); };
  const auto value = [](const float* stream, int i) {
    return spread<Texels, lanes>(load<Texels>(stream + i));
  };
  const Floats<N> own = at(k);
  Floats<N> sum = rounded(value(row_sums, k) * own);
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
                           const ProductVectors& v, ProductSums& total) {
  constexpr int wide = register_floats / lanes, registers = partial_sums / register_floats;
  RunSums<lanes, register_floats> sums[registers];
  RunSums<lanes, lanes> rest;
  int i = 0;
  for (; i + registers * wide <= run.count; i += registers * wide)
    for (int n = 0; n < registers; ++n) {
      const int j = i + n * wide;
      product_at<lanes, wide>(A, row_sums, v, run.first + j, run.up + j, run.down + j, sums[n]);
    }
  for (; i < run.count; ++i)
    product_at<lanes, 1>(A, row_sums, v, run.first + i, run.up + i, run.down + i, rest);
  for (const auto& sum : sums) sum.add_to(total);
  rest.add_to(total);
}

inline int position_of(const Selection& rows, std::int64_t i) {
  return rows.positions ? rows.positions[i] : int(i);
}

template <int lanes>
inline void multiply_rows(const ListedRows& A, const float* row_sums, const Selection& rows,
                          const ProductVectors& v, ProductSums& total) {
  RunSums<lanes, lanes> sums;
  for (std::int64_t i = rows.begin; i < rows.end; ++i) {
    const int p = position_of(rows, i);
    const std::int64_t k = row_at(A, p), here = k * lanes;
    const Floats<lanes> own = load<lanes>(v.x + here);
    Floats<lanes> sum = rounded(row_sums[k] * own);
    for (std::int64_t e = A.start[p]; e < A.start[p + 1]; ++e)
      sum += A.values[e] * (load<lanes>(v.x + std::int64_t(A.columns[e]) * lanes) - own);
    store<lanes>(v.y + here, sum);
    sums.add(own, sum, load<lanes>(v.r + here));
  }
  sums.add_to(total);
}

template <int lanes>
inline void residual_of_rows(const ListedRows& A, const Selection& rows, const float* b,
                             const float* x, float* r) {
  for (std::int64_t i = rows.begin; i < rows.end; ++i) {
    const int p = position_of(rows, i);
    store<lanes>(r + std::int64_t(row_at(A, p)) * lanes, residual_at<lanes>(A, p, b, x));
  }
}

// The functions of the table.

template <Order order>
void relax(int lanes, const Stencils& A, const StencilRun* runs, int count, const float* b,
           float* x) {
  for_lanes(lanes, [&](auto size) {
    for (int i = 0; i < count; ++i)
      relax_run<decltype(size)::lanes, order>(A, runs[order == Order::forward ? i : count - 1 - i], b, x);
  });
}

void residual(int lanes, const Stencils& A, const StencilRun* runs, std::int64_t count,
              const float* b, const float* x, float* r) {
  for_lanes(lanes, [&](auto size) {
    for (std::int64_t i = 0; i < count; ++i) residual_of_run<decltype(size)::lanes>(A, runs[i], b, x, r);
  });
}

void residual_of_listed(int lanes, const ListedRows& A, const Selection& rows, const float* b,
                        const float* x, float* r) {
  for_lanes(lanes, [&](auto size) { residual_of_rows<decltype(size)::lanes>(A, rows, b, x, r); });
}

void multiply(int lanes, const Stencils& A, const float* row_sums, const StencilRun* runs,
              std::int64_t count, const ProductVectors& v, ProductSums& sums) {
  for (std::int64_t i = 0; i < count; ++i)
    if (lanes == 1)
      product_of_run<1>(A, row_sums, runs[i], v, sums);
    else
      product_of_run<4>(A, row_sums, runs[i], v, sums);
}

void multiply_listed(int lanes, const ListedRows& A, const float* row_sums, const Selection& rows,
                     const ProductVectors& v, ProductSums& sums) {
  if (lanes == 1)
    multiply_rows<1>(A, row_sums, rows, v, sums);
  else
    multiply_rows<4>(A, row_sums, rows, v, sums);
}

/// A value of the matrix for each of eight unknowns, high + low.
inline void add_up(const float* high, const float* low, double* sums) {
  for (int i = 0; i < 8; i += register_doubles)
    store(sums + i, __builtin_convertvector(load<register_doubles>(high + i), Doubles) +
                        __builtin_convertvector(load<register_doubles>(low + i), Doubles));
}

void multiply_in_double(const StencilStreams& high, const StencilStreams& low, const StencilRun& run,
                        const double* X, std::int64_t stride, double* product) {
  typedef double Four __attribute__((vector_size(32)));
  const auto row_of = [&](int k) {
    Four row;
    std::memcpy(&row, X + k * stride, sizeof row);
    return row;
  };
  for (int begin = 0; begin < run.count; begin += 8) {
    const int first = run.first + begin, up = run.up + begin, down = run.down + begin;
    double value[9][8];
    add_up(high.se + up - 1, low.se + up - 1, value[0]);
    add_up(high.s + up, low.s + up, value[1]);
    add_up(high.sw + up + 1, low.sw + up + 1, value[2]);
    add_up(high.e + first - 1, low.e + first - 1, value[3]);
    add_up(high.c + first, low.c + first, value[4]);
    add_up(high.e + first, low.e + first, value[5]);
    add_up(high.sw + first, low.sw + first, value[6]);
    add_up(high.s + first, low.s + first, value[7]);
    add_up(high.se + first, low.se + first, value[8]);
    const int count = run.count - begin < 8 ? run.count - begin : 8;
    for (int i = 0; i < count; ++i) {
      const int rows[3] = {up + i, first + i, down + i};
      Four parts[3] = {};
      for (int j = 0; j < 3; ++j)
        for (int r = 0; r < 3; ++r) parts[r] += value[3 * r + j][i] * row_of(rows[r] - 1 + j);
      const Four sum = parts[0] + parts[1] + parts[2];
      std::memcpy(product + 4 * (begin + i), &sum, sizeof sum);
    }
  }
}

}  // namespace

const StencilKernels stencil_kernels = {relax<Order::forward>, relax<Order::backward>, residual,
                                        residual_of_listed,    multiply,               multiply_listed,
                                        multiply_in_double};

}  // namespace mq::MARQUETRY_FORM
