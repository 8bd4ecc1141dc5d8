/// Per channel, with C the cycle:
///
///     z = C·r,   β = −⟨z, q⟩/⟨p, q⟩,   p = z + β·p,   q = A·p,   α = ⟨p, r⟩/⟨p, q⟩,
///     X += α·p,   r −= α·q
///
/// β makes p conjugate to its predecessor whatever r is, so that nothing is lost where r is renewed.
/// A channel that has reached the tolerance rests with α = 0. X is in double from the first step on:
/// where A is mostly stiffness, rounding of its slow waves would be a residual as large as the one that
/// three digits are to be gained on. The four lanes of a single channel are partial
/// sums of that channel; vectors are then walked in the same way in either case.

#include "mq/linear/mixed_cg.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "mq/base/parallel.h"
#include "mq/linear/error_estimate.h"
#include "mq/linear/kernels/vector_kernels.h"

namespace mq {

namespace {

using Clock = std::chrono::steady_clock;
typedef double Double4 __attribute__((vector_size(32)));

constexpr std::int64_t block_values = 65536;
constexpr int max_lost = 2;           // directions in a row that rounding may spoil
constexpr int max_idle = 3;           // renewals in a row that find the residual where it was
constexpr double diverged = 100;      // times the first residual; a little more than 1 may pass
constexpr double renew_below = 1e-3;  // digits a residual in single precision may lose, see above

/// The four sums of all four-value steps; for one channel their total, four times.
Double4 finish(Double4 sum, int lanes) {
  if (lanes == 4) return sum;
  return Double4{} + (sum[0] + sum[1] + sum[2] + sum[3]);
}

/// Σ over the blocks of vectors of `size` values of what body(begin, end, sums) adds to four sums.
template <class Body>
Double4 sum_of_blocks(std::int64_t size, const Body& body) {
  return parallel_sum(size, Double4{}, [&](std::int64_t begin, std::int64_t end) {
    double sums[4] = {};
    body(begin, end, sums);
    return Double4{sums[0], sums[1], sums[2], sums[3]};
  }, block_values);
}

std::array<float, 4> rounded(Double4 v) {
  return {float(v[0]), float(v[1]), float(v[2]), float(v[3])};
}

Double4 dot(const LaneVector& a, const LaneVector& b) {
  return finish(sum_of_blocks(a.size(), [&](std::int64_t begin, std::int64_t end, double* sums) {
    vector_kernels().dot(a.data(), b.data(), begin, end, sums);
  }), a.lanes());
}

/// Takes the special rows of a scaling out of v while it lives: they are 0 in v, so that a sum over v
/// leaves them out instead of being drowned by them.
class SpecialRows {
 public:
  SpecialRows(const Scaling& scaling, LaneVector& v) : scaling_(scaling), v_(v) {
    kept_.reserve(scaling.special.size() * v.lanes());
    for (const WeightedIndex& row : scaling.special)
      for (int lane = 0; lane < v.lanes(); ++lane) {
        float& value = at(row.index, lane);
        kept_.push_back(value);
        value = 0;
      }
  }
  ~SpecialRows() {
    std::size_t i = 0;
    for (const WeightedIndex& row : scaling_.special)
      for (int lane = 0; lane < v_.lanes(); ++lane) at(row.index, lane) = kept_[i++];
  }
  SpecialRows(const SpecialRows&) = delete;

  /// Subtracts α times another vector's special rows.
  void subtract(Double4 alpha, const SpecialRows& other) {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      kept_[i] -= float(alpha[int(i) % v_.lanes()]) * other.kept_[i];
  }

  /// Their part of ‖D⁻¹·v‖² per channel.
  Double4 squared() const {
    Double4 sum{};
    std::size_t i = 0;
    for (const WeightedIndex& row : scaling_.special)
      for (int lane = 0; lane < v_.lanes(); ++lane, ++i) {
        const double value = double(kept_[i]) * double(row.weight);
        sum[lane] += value * value;
      }
    return v_.lanes() == 4 ? sum : Double4{} + sum[0];
  }

 private:
  float& at(int row, int lane) { return v_.data()[std::int64_t(row) * v_.lanes() + lane]; }

  const Scaling& scaling_;
  LaneVector& v_;
  std::vector<float> kept_;
};

/// ‖D⁻¹·r‖² per channel: the residual of the system as it was given.
Double4 squared_norm(const Scaling& scaling, LaneVector& r) {
  const SpecialRows special(scaling, r);
  return dot(r, r) + special.squared();
}

/// p = z + β·p
void next_direction(const LaneVector& z, Double4 beta, LaneVector& p) {
  const std::array<float, 4> factor = rounded(beta);
  parallel_blocks(z.size(), block_values, [&](std::int64_t begin, std::int64_t end) {
    vector_kernels().next_direction(z.data(), factor.data(), p.data(), begin, end);
  });
}

/// r −= α·q; returns ‖D⁻¹·r‖² per channel.
Double4 reduce_residual(const Scaling& scaling, LaneVector& q, Double4 alpha, LaneVector& r) {
  const SpecialRows of_q(scaling, q);
  SpecialRows of_r(scaling, r);
  of_r.subtract(alpha, of_q);
  const std::array<float, 4> factor = rounded(alpha);
  const Double4 sum =
      sum_of_blocks(r.size(), [&](std::int64_t begin, std::int64_t end, double* sums) {
        vector_kernels().reduce(q.data(), factor.data(), r.data(), begin, end, sums);
      });
  return finish(sum, r.lanes()) + of_r.squared();
}

/// The largest values by size, per channel.
struct Largest {
  Double4 change{}, value{};

  friend Largest operator+(const Largest& a, const Largest& b) {
    return {a.change > b.change ? a.change : b.change, a.value > b.value ? a.value : b.value};
  }
};

Double4 size_of(Double4 v) { return v < 0 ? -v : v; }

/// Columns first … first + channels − 1 of X += α·p. Returns the largest of α·p and of those columns,
/// which special rows of the scaling (units of their own) have no part in.
Largest add_to_solution(const Scaling& scaling, const LaneVector& p, Double4 alpha, int first,
                        int channels, Signal& X) {
  const int lanes = p.lanes();
  Largest found = parallel_sum(X.rows(), Largest{}, [&](std::int64_t begin, std::int64_t end) {
    Largest here;
    for (std::int64_t k = begin; k < end; ++k) {
      double* x = X.data() + k * X.cols() + first;
      Double4 change{}, value{};
      for (int c = 0; c < channels; ++c) {
        change[c] = double(p.data()[k * lanes + c]);
        value[c] = x[c] += alpha[c] * change[c];
      }
      if (scaling.row(k) == 1) here = here + Largest{size_of(change), size_of(value)};
    }
    return here;
  }, block_values / 4);
  found.change *= size_of(alpha);
  return found;
}

/// The functions that are constant on each component, D⁻¹·1 in the scaled system.
class Constants {
 public:
  using Means = std::vector<std::array<double, 4>>;

  Constants(const Components& components, const Scaling& scaling)
      : components_(components), scaling_(scaling) {}

  /// Per component the coefficient of its constant in v, 0 where it is not singular; empty if none
  /// is. `value(k, c)` gives v.
  template <class Value>
  Means coefficients(std::int64_t rows, int channels, const Value& value) const {
    if (!components_.any_singular()) return {};
    Means mean(components_.size.size(), {0, 0, 0, 0});
    for (std::int64_t k = 0; k < rows; ++k)
      for (int c = 0; c < channels; ++c) mean[component(k)][c] += value(k, c) / scaling_.row(k);
    for (std::size_t i = 0; i < mean.size(); ++i)
      for (double& m : mean[i]) m *= components_.singular[i] ? 1 / components_.size[i] : 0;
    return mean;
  }

  double at(const Means& mean, std::int64_t k, int c) const {
    return mean[component(k)][c] / scaling_.row(k);
  }

  void remove(LaneVector& v) const {
    const int lanes = v.lanes();
    const std::int64_t rows = v.size() / lanes;
    const Means mean = coefficients(
        rows, lanes, [&](std::int64_t k, int c) { return double(v.data()[k * lanes + c]); });
    if (mean.empty()) return;
    parallel_for(rows, [&](std::int64_t k) {
      for (int c = 0; c < lanes; ++c) v.data()[k * lanes + c] -= float(at(mean, k, c));
    });
  }

 private:
  int component(std::int64_t k) const {
    return components_.component.empty() ? 0 : components_.component[k];
  }

  const Components& components_;
  const Scaling& scaling_;
};

/// Columns first … of B, scaled, without what it holds of constants on singular components.
class RightHandSide {
 public:
  RightHandSide(const Signal& B, int first, int channels, const Scaling& scaling,
                const Constants& constants)
      : B_(B), first_(first), channels_(channels), scaling_(scaling), constants_(constants),
        mean_(constants.coefficients(B.rows(), channels, [&](std::int64_t k, int c) {
          return scaled(k, c);
        })) {}

  double operator()(std::int64_t k, int c) const {
    return mean_.empty() ? scaled(k, c) : scaled(k, c) - constants_.at(mean_, k, c);
  }

  template <int channels>
  Double4 row(std::int64_t k) const {
    Double4 row{};
    const double* values = B_.data() + k * B_.cols() + first_;
    for (int c = 0; c < channels; ++c) row[c] = values[c];
    row *= scaling_.common * scaling_.row(k);
    if (!mean_.empty())
      for (int c = 0; c < channels; ++c) row[c] -= constants_.at(mean_, k, c);
    return row;
  }

  /// ‖D⁻¹·‖² of each column.
  Double4 squared_norm() const {
    return parallel_sum(B_.rows(), Double4{}, [&](std::int64_t begin, std::int64_t end) {
      Double4 sum{};
      for (std::int64_t k = begin; k < end; ++k)
        for (int c = 0; c < channels_; ++c) {
          const double value = (*this)(k, c) / scaling_.row(k);
          sum[c] += value * value;
        }
      return sum;
    });
  }

 private:
  double scaled(std::int64_t k, int c) const {
    return scaling_.common * scaling_.row(k) * B_(k, first_ + c);
  }

  const Signal& B_;
  int first_, channels_;
  const Scaling& scaling_;
  const Constants& constants_;
  Constants::Means mean_;
};

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
                     const RightHandSide& B, const Row& x, LaneVector& r) {
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

/// B − (high + low)·X for columns first … of X, in double until it is rounded to r.
template <int channels>
void true_residual(const StencilMatrix& high, const StencilMatrix& low, const RightHandSide& B,
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

/// r = B, rounded.
void take_right_hand_side(const RightHandSide& B, int channels, LaneVector& r) {
  parallel_for(r.size() / r.lanes(), [&](std::int64_t k) {
    for (int c = 0; c < channels; ++c) r.data()[k * r.lanes() + c] = float(B(k, c));
  });
}

/// Whether columns first … first + channels − 1 of X are all 0.
bool is_zero(const Signal& X, int first, int channels) {
  return X.middleCols(first, channels).isZero(0);
}

/// The conjugate gradients of up to four channels.
class Group {
 public:
  /// X is that of the scaled system.
  Group(const StencilMatrix& high, const StencilMatrix& low, const Scaling& scaling,
        const Multigrid& multigrid, const Components& components, const Signal& B, Signal& X,
        int first, const MixedCgOptions& options)
      : high_(high), low_(low), scaling_(scaling), multigrid_(multigrid),
        constants_(components, scaling), X_(X), first_(first), channels_(std::min(4, int(B.cols()) - first)),
        B_(B, first, channels_, scaling, constants_),
        lanes_(lanes_for(channels_)), workspace_(multigrid, lanes_), options_(options) {
    for (LaneVector* v : {&r_, &z_, &p_, &q_}) *v = LaneVector(B.rows(), lanes_);
    if (is_zero(X, first, channels_))
      take_right_hand_side(B_, channels_, r_);
    else
      take_true_residual();
    constants_.remove(r_);
    squared_ = renewed_ = squared_norm(scaling_, r_);
    start_ = squared_;
    wanted_ = B_.squared_norm();
    for (int c = 0; c < 4; ++c) {
      if (!std::isfinite(start_[c]) || !std::isfinite(wanted_[c]))
        throw SolverError("the right-hand side or the first guess holds a value that is not finite");
      // A guess that is better than the tolerance asks for nothing more.
      wanted_[c] = options.tolerance * options.tolerance * (wanted_[c] > 0 ? wanted_[c] : start_[c]);
    }
  }

  bool converged(int c) const {
    return c >= channels_ || squared_[c] == 0 ||
           (cycles_ >= options_.least_cycles && !(squared_[c] > wanted_[c]) &&
            error_[c].within(options_.tolerance));
  }
  bool converged() const {
    return converged(0) && converged(1) && converged(2) && converged(3);
  }
  bool active(int c) const {
    return !converged(c) && lost_[c] < max_lost && idle_[c] < max_idle;
  }
  bool active() const { return active(0) || active(1) || active(2) || active(3); }

  /// Of the worst channel.
  double error() const {
    double worst = 0;
    for (int c = 0; c < channels_; ++c) worst = std::max(worst, error_[c].relative());
    return worst;
  }

  /// ‖r‖² / ‖r₀‖² of the worst channel.
  double ratio() const {
    double worst = 0;
    for (int c = 0; c < channels_; ++c)
      if (start_[c] > 0) worst = std::max(worst, squared_[c] / start_[c]);
    return worst;
  }

  void iterate() {
    multigrid_.cycle(r_.data(), z_.data(), workspace_);
    constants_.remove(z_);
    Double4 beta{}, alpha{};
    if (cycles_ > 0) beta = -dot(z_, q_);
    for (int c = 0; c < 4; ++c) beta[c] = form_[c] > 0 ? beta[c] / form_[c] : 0;
    next_direction(z_, beta, p_);
    const StencilMatrix::Products of_p = high_.multiply(lanes_, p_.data(), r_.data(), q_.data());
    for (int c = 0; c < lanes_; ++c) {
      form_[c] = of_p.with_product[c];
      alpha[c] = active(c) ? step(c, of_p.with_r[c]) : 0;
    }
    if (lanes_ == 1) {
      alpha = Double4{} + alpha[0];
      form_ = Double4{} + form_[0];
    }
    const Largest found = add_to_solution(scaling_, p_, alpha, first_, channels_, X_);
    for (int c = 0; c < channels_; ++c)
      if (alpha[c] != 0) error_[c].add_step(found.change[c], found.value[c]);
    squared_ = reduce_residual(scaling_, q_, alpha, r_);
    ++cycles_;
    if (needs_renewal()) renew();
  }

 private:
  /// ⟨p, r⟩/⟨p, A·p⟩; 0 where the quadratic form is lost in rounding (a direction along which the
  /// matrix nearly vanishes). The next direction is a new one; a channel that finds none rests.
  double step(int c, double descent) {
    lost_[c] = form_[c] > 0 ? 0 : lost_[c] + 1;
    return form_[c] > 0 ? descent / form_[c] : 0;
  }

  bool needs_renewal() const {
    if (!active()) return true;
    for (int c = 0; c < channels_; ++c)
      if (!(squared_[c] > renew_below * renew_below * renewed_[c])) return true;
    return false;
  }

  /// r = B − A·X in double.
  void renew() {
    take_true_residual();
    constants_.remove(r_);
    squared_ = squared_norm(scaling_, r_);
    // Where rounding of X is what is left, the residual in single precision falls and the true one
    // does not.
    for (int c = 0; c < 4; ++c) idle_[c] = squared_[c] > renewed_[c] / 4 ? idle_[c] + 1 : 0;
    renewed_ = squared_;
  }

  void take_true_residual() {
    switch (channels_) {
      case 1: return true_residual<1>(high_, low_, B_, X_, first_, r_);
      case 2: return true_residual<2>(high_, low_, B_, X_, first_, r_);
      case 3: return true_residual<3>(high_, low_, B_, X_, first_, r_);
      default: return true_residual<4>(high_, low_, B_, X_, first_, r_);
    }
  }

  const StencilMatrix& high_;
  const StencilMatrix& low_;
  const Scaling& scaling_;
  const Multigrid& multigrid_;
  Constants constants_;
  Signal& X_;
  int first_, channels_;
  RightHandSide B_;
  int lanes_;
  Multigrid::Workspace workspace_;
  const MixedCgOptions& options_;
  LaneVector r_, z_, p_, q_;
  Double4 squared_{}, renewed_{}, start_{}, wanted_{};
  Double4 form_{};  ///< ⟨p, A·p⟩
  std::array<int, 4> lost_ = {0, 0, 0, 0};
  std::array<ErrorEstimate, 4> error_;
  std::array<int, 4> idle_ = {0, 0, 0, 0};
  int cycles_ = 0;
};

}  // namespace

bool Components::any_singular() const {
  return std::find(singular.begin(), singular.end(), char(1)) != singular.end();
}

SolveReport mixed_conjugate_gradients(const StencilMatrix& high, const StencilMatrix& low,
                                      const Scaling& scaling, const Multigrid& multigrid,
                                      const Components& components, const Signal& B, Signal& X,
                                      const MixedCgOptions& options, const Progress& progress) {
  const auto start = Clock::now();
  SolveReport report;
  report.method = "multigrid";
  // x̂ = D⁻¹·x for the time of the solve; powers of two, so that nothing is lost on the way back.
  for (const WeightedIndex& row : scaling.special) X.row(row.index) *= double(row.weight);
  for (int first = 0; first < B.cols(); first += 4) {
    Group group(high, low, scaling, multigrid, components, B, X, first, options);
    if (group.active() && report.residuals.empty()) report.residuals.push_back(1);
    int cycle = 0;
    while (group.active() && cycle < options.max_cycles) {
      group.iterate();
      ++cycle;
      const double ratio = std::sqrt(group.ratio());
      if (!std::isfinite(ratio)) throw SolverError("the multigrid cycle met a value that is not finite");
      if (ratio > diverged)
        throw SolverError(fmt::format(
            "multigrid diverges: after {} cycles the residual is {:.1e} times what it was", cycle, ratio));
      // Groups of channels run one after another; the worst of them counts.
      if (int(report.residuals.size()) <= cycle) report.residuals.push_back(0);
      report.residuals[cycle] = std::max(report.residuals[cycle], ratio);
      const double done =
          std::min(1.0, std::log(std::max(ratio, 1e-300)) / std::log(options.tolerance));
      progress.at((first + done * std::min(4.0, double(B.cols()) - first)) / double(B.cols()),
                  fmt::format("residual {:.0e}", ratio));
    }
    report.cycles = std::max(report.cycles, cycle);
    report.converged = report.converged && group.converged();
    report.error = std::max(report.error, group.error());
  }
  for (const WeightedIndex& row : scaling.special) X.row(row.index) /= double(row.weight);
  report.solve_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report;
}

}  // namespace mq
