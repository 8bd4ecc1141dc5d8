#include "mq/linear/detail/true_residual.h"

#include <algorithm>
#include <cstring>

#include "mq/linear/kernels/stencil_kernels.h"

namespace mq {
namespace {

/// Rows of up to four columns of X, from the `first`th on, as four lanes in double; lanes beyond the
/// columns hold whatever follows in memory.
template <int channels>
class Rows {
 public:
  Rows(const Signal& X, int first)
      : x_(X.data() + first), stride_(X.cols()), last_(X.size() - first - 4) {}

  /// Whether four values from each of the first `count` rows are within X.
  bool whole(std::int64_t count) const { return channels == 4 || (count - 1) * stride_ <= last_; }

  Double4 operator()(std::int64_t k) const {
    Double4 row{};
    if (whole(k + 1))
      std::memcpy(&row, x_ + k * stride_, sizeof row);
    else
      std::memcpy(&row, x_ + k * stride_, channels * sizeof(double));
    return row;
  }
  const double* data() const { return x_; }
  std::int64_t stride() const { return stride_; }

 private:
  const double* x_;
  std::int64_t stride_, last_;
};

template <int channels>
void store_rounded(const Double4& sum, std::int64_t k, LaneVector& r) {
  for (int c = 0; c < channels; ++c) r.data()[k * r.lanes() + c] = float(sum[c]);
}

/// The residual in a run where the kernel may not read whole rows, at the end of X.
template <int channels>
void residual_at_end(const StencilMatrix& high, const StencilMatrix& low, const StencilRun& run,
                     const ScaledRightHandSide& B, const Rows<channels>& x, LaneVector& r) {
  for (int i = 0; i < run.count; ++i) {
    const int k = run.first + i, u = run.up + i, d = run.down + i;
    const auto term = [&](float of_high, float of_low, int row) { return (double(of_high) + double(of_low)) * x(row); };
    Double4 sum = B.row<channels>(k);
    sum -= term(high.south_east(u - 1), low.south_east(u - 1), u - 1) + term(high.south(u), low.south(u), u) +
           term(high.south_west(u + 1), low.south_west(u + 1), u + 1);
    sum -= term(high.east(k - 1), low.east(k - 1), k - 1) + term(high.centre(k), low.centre(k), k) +
           term(high.east(k), low.east(k), k + 1);
    sum -= term(high.south_west(k), low.south_west(k), d - 1) + term(high.south(k), low.south(k), d) +
           term(high.south_east(k), low.south_east(k), d + 1);
    store_rounded<channels>(sum, k, r);
  }
}

template <int channels>
void residual_of_run(const StencilMatrix& high, const StencilMatrix& low, const StencilRun& run,
                     const ScaledRightHandSide& B, const Rows<channels>& x, LaneVector& r) {
  if (!x.whole(std::int64_t(run.down) + run.count + 1)) return residual_at_end(high, low, run, B, x, r);
  double product[4 * StencilLayout::max_run];
  stencil_kernels().multiply_in_double(high.stencils(), low.stencils(), run, x.data(), x.stride(), product);
  B.subtract<channels>(product, run.first, run.count, r.data() + std::int64_t(run.first) * r.lanes());
}

/// The same for a number of channels that the compiler knows.
template <int channels>
void residual_of_columns(const StencilMatrix& high, const StencilMatrix& low, const ScaledRightHandSide& B,
                   const Signal& X, int first, LaneVector& r) {
  const StencilLayout& layout = high.layout();
  const Rows<channels> rows(X, first);
  parallel_for(std::int64_t(layout.runs.size()), [&](std::int64_t i) {
    residual_of_run(high, low, layout.runs[i], B, rows, r);
  }, 64);
  parallel_for(std::int64_t(layout.irregular.size()), [&](std::int64_t p) {
    const StencilMatrix::Row a = high.listed_row(int(p));
    const float* const low_values = low.listed_values(int(p));
    const int k = layout.irregular[p];
    Double4 sum = B.row<channels>(k);
    sum -= (double(a.diagonal) + double(low.centre(k))) * rows(k);
    for (int i = 0; i < a.count; ++i)
      sum -= (double(a.values[i]) + double(low_values[i])) * rows(a.columns[i]);
    store_rounded<channels>(sum, k, r);
  });
}

}  // namespace

void true_residual(const StencilMatrix& high, const StencilMatrix& low, const ScaledRightHandSide& B,
                   const Signal& X, int first, int channels, LaneVector& r) {
  switch (channels) {
    case 1: return residual_of_columns<1>(high, low, B, X, first, r);
    case 2: return residual_of_columns<2>(high, low, B, X, first, r);
    case 3: return residual_of_columns<3>(high, low, B, X, first, r);
    default: return residual_of_columns<4>(high, low, B, X, first, r);
  }
}

void take_right_hand_side(const ScaledRightHandSide& B, int channels, LaneVector& r) {
  parallel_for(r.size() / r.lanes(), [&](std::int64_t k) {
    for (int c = 0; c < channels; ++c) r.data()[k * r.lanes() + c] = float(B(k, c));
  });
}

}  // namespace mq
