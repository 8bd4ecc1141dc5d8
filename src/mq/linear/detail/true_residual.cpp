#include "mq/linear/detail/true_residual.h"

#include <algorithm>
#include <cstring>

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

  Double4 four(std::int64_t k) const {
    Double4 row;
    std::memcpy(&row, x_ + k * stride_, sizeof row);
    return row;
  }
  Double4 operator()(std::int64_t k) const {
    if (whole(k + 1)) return four(k);
    Double4 row{};
    std::memcpy(&row, x_ + k * stride_, channels * sizeof(double));
    return row;
  }

 private:
  const double* x_;
  std::int64_t stride_, last_;
};

template <int channels>
void store_rounded(const Double4& sum, std::int64_t k, LaneVector& r) {
  for (int c = 0; c < channels; ++c) r.data()[k * r.lanes() + c] = float(sum[c]);
}

/// The nine values of eight unknowns from the `begin`th of a run on, high + low in double; those beyond
/// the run's end are read and mean nothing.
struct StencilValues {
  static constexpr int unknowns = 8;
  double value[9][unknowns];

  StencilValues(const StencilMatrix& high, const StencilMatrix& low, const StencilRun& run, int begin) {
    const int k = run.first + begin, u = run.up + begin;
    const auto fill = [&](int entry, const float* a, const float* b) {
      for (int i = 0; i < unknowns; ++i) value[entry][i] = double(a[i]) + double(b[i]);
    };
    fill(0, high.south_easts(u - 1), low.south_easts(u - 1));
    fill(1, high.souths(u), low.souths(u));
    fill(2, high.south_wests(u + 1), low.south_wests(u + 1));
    fill(3, high.easts(k - 1), low.easts(k - 1));
    fill(4, high.centres(k), low.centres(k));
    fill(5, high.easts(k), low.easts(k));
    fill(6, high.south_wests(k), low.south_wests(k));
    fill(7, high.souths(k), low.souths(k));
    fill(8, high.south_easts(k), low.south_easts(k));
  }
};

/// The residual in a run; x(k) is row k of X.
template <int channels, class Row>
void residual_of_run(const StencilMatrix& high, const StencilMatrix& low, const StencilRun& run,
                     const ScaledRightHandSide& B, const Row& x, LaneVector& r) {
  constexpr int step = StencilValues::unknowns;
  for (int begin = 0; begin < run.count; begin += step) {
    const int count = std::min(step, run.count - begin);
    const StencilValues A(high, low, run, begin);
    for (int i = 0; i < count; ++i) {
      const int k = run.first + begin + i, u = run.up + begin + i, d = run.down + begin + i;
      Double4 sum = B.row<channels>(k);
      for (int j = 0; j < 3; ++j)
        sum -= A.value[j][i] * x(u - 1 + j) + A.value[3 + j][i] * x(k - 1 + j) +
               A.value[6 + j][i] * x(d - 1 + j);
      store_rounded<channels>(sum, k, r);
    }
  }
}

/// The same for a number of channels that the compiler knows.
template <int channels>
void residual_of_columns(const StencilMatrix& high, const StencilMatrix& low, const ScaledRightHandSide& B,
                   const Signal& X, int first, LaneVector& r) {
  const StencilLayout& layout = high.layout();
  const Rows<channels> rows(X, first);
  parallel_for(std::int64_t(layout.runs.size()), [&](std::int64_t i) {
    const StencilRun& run = layout.runs[i];
    if (rows.whole(std::int64_t(run.down) + run.count + 1))
      residual_of_run<channels>(high, low, run, B, [&](int k) { return rows.four(k); }, r);
    else
      residual_of_run<channels>(high, low, run, B, rows, r);
  }, 64);
  parallel_for(std::int64_t(layout.irregular.size()), [&](std::int64_t p) {
    const StencilMatrix::Row a = high.listed_row(int(p)), b = low.listed_row(int(p));
    const int k = layout.irregular[p];
    Double4 sum = B.row<channels>(k);
    sum -= (double(a.diagonal) + double(b.diagonal)) * rows(k);
    for (int i = 0; i < a.count; ++i)
      sum -= (double(a.values[i]) + double(b.values[i])) * rows(a.columns[i]);
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
