/// X ← V(A, B, X) until the residual is small (thesis 5.8.2). The thesis says neither when to stop
/// nor where to begin; "between two and four V-cycles" is what it found enough to look at.

#include "mq/baseline/reference_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/baseline/reference_cycle.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/error_estimate.h"
#include "mq/linear/lanes.h"
#include "mq/linear/residual.h"

namespace mq {

namespace {

/// Removes from X, on singular components, what makes its sums differ from those of `like`.
void set_sums(const NullSpace& null_space, const Signal& like, Signal& X) {
  if (null_space.empty()) return;
  const std::vector<int>& component = null_space.component;
  const Signal excess = component_sums(component, X) - component_sums(component, like);
  const Signal size = component_sums(component, Signal::Ones(X.rows(), 1));
  for (Eigen::Index k = 0; k < X.rows(); ++k)
    if (const int c = component[k]; null_space.singular[c]) X.row(k) -= excess.row(c) / size(c, 0);
}

/// Rows of `channels` columns of S from `first` on, `lanes` apart; and back.
template <class Real>
std::vector<Real> to_lanes(const Signal& S, int first, int channels, int lanes) {
  std::vector<Real> v(std::size_t(S.rows()) * lanes);
  parallel_for(S.rows(), [&](std::int64_t k) {
    for (int c = 0; c < channels; ++c) v[k * lanes + c] = Real(S(k, first + c));
  });
  return v;
}

template <class Real>
void from_lanes(const std::vector<Real>& v, int first, int channels, int lanes, Signal& S) {
  parallel_for(S.rows(), [&](std::int64_t k) {
    for (int c = 0; c < channels; ++c) S(k, first + c) = double(v[k * lanes + c]);
  });
}

/// ‖v‖² of each channel.
template <class Real>
Eigen::RowVectorXd squared_norms(const std::vector<Real>& v, int channels, int lanes) {
  return parallel_sum(std::int64_t(v.size()) / lanes, Eigen::RowVectorXd::Zero(channels).eval(),
                      [&](std::int64_t begin, std::int64_t end) {
                        Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(channels);
                        for (std::int64_t k = begin; k < end; ++k)
                          for (int c = 0; c < channels; ++c)
                            sum[c] += double(v[k * lanes + c]) * double(v[k * lanes + c]);
                        return sum;
                      });
}

/// The largest values by size, per channel.
struct Largest {
  std::array<double, 4> change{}, value{};

  friend Largest operator+(Largest a, const Largest& b) {
    for (std::size_t c = 0; c < 4; ++c) {
      a.change[c] = std::max(a.change[c], b.change[c]);
      a.value[c] = std::max(a.value[c], b.value[c]);
    }
    return a;
  }
};

/// What a cycle changed, per channel.
template <class Real>
void add_steps(const std::vector<Real>& before, const std::vector<Real>& after, int lanes,
               std::vector<ErrorEstimate>& error) {
  const Largest found = parallel_sum(
      std::int64_t(after.size()) / lanes, Largest{}, [&](std::int64_t begin, std::int64_t end) {
        Largest here;
        for (std::int64_t k = begin; k < end; ++k)
          for (std::size_t c = 0; c < error.size(); ++c) {
            const double now = double(after[k * lanes + c]);
            here.change[c] =
                std::max(here.change[c], std::abs(now - double(before[k * lanes + c])));
            here.value[c] = std::max(here.value[c], std::abs(now));
          }
        return here;
      });
  for (std::size_t c = 0; c < error.size(); ++c) error[c].add_step(found.change[c], found.value[c]);
}

template <class Real>
class ReferenceSolver final : public LinearSolver {
 public:
  ReferenceSolver(const SparseMatrix& A, const Texels& texels, const ReferenceOptions& options,
                  const Progress& progress)
      : options_(options), cycle_(A, texels, options, progress) {
    setup_seconds_ = watch_.seconds();
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    require(B.rows() == cycle_.rows() && X.rows() == B.rows() && X.cols() == B.cols(),
            fmt::format("a system of {} rows was given a right-hand side of {} × {} and a first "
                        "guess of {} × {}",
                        cycle_.rows(), B.rows(), B.cols(), X.rows(), X.cols()));
    if (!B.allFinite() || !X.allFinite())
      throw SolverError("the right-hand side or the first guess holds a value that is not finite");
    const Stopwatch watch;
    SolveReport report;
    report.method = sizeof(Real) == 8 ? "reference multigrid" : "reference multigrid, float";
    report.setup_seconds = setup_seconds_;
    if (B.size() > 0) {
      Signal regularised_system = B;
      set_sums(cycle_.null_space(), Signal::Zero(B.rows(), B.cols()), regularised_system);
      const Signal guess = X;
      for (int first = 0; first < B.cols(); first += 4)
        solve_channels(regularised_system, first, std::min(4, int(B.cols()) - first), X, report,
                       progress.step("channels", 4.0 / double(B.cols())));
      set_sums(cycle_.null_space(), guess, X);
    }
    report.solve_seconds = watch.seconds();
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    const Stopwatch watch;
    cycle_.set_values(A, progress);
    setup_seconds_ = watch.seconds();
  }

 private:
  /// Cycles on columns first … first + channels − 1. Groups of channels run one after another; the
  /// worst of them counts in the report.
  void solve_channels(const Signal& B, int first, int channels, Signal& X, SolveReport& report,
                      const Progress& progress) const {
    const int lanes = lanes_for(channels);
    const std::vector<Real> b = to_lanes<Real>(B, first, channels, lanes);
    std::vector<Real> x = to_lanes<Real>(X, first, channels, lanes), r(x.size());
    const Eigen::RowVectorXd wanted =
        options_.tolerance * options_.tolerance * squared_norms(b, channels, lanes);
    const auto squared_residual = [&] {
      cycle_.residual(lanes, b.data(), x.data(), r.data());
      return squared_norms(r, channels, lanes);
    };
    const Eigen::RowVectorXd before = squared_residual();
    Eigen::RowVectorXd now = before;
    std::vector<ErrorEstimate> error(channels);
    const auto converged = [&] {
      return (now.array() <= wanted.array()).all() &&
             std::ranges::all_of(error,
                                 [&](const auto& e) { return e.within(options_.tolerance); });
    };
    if (!converged() && report.residuals.empty()) report.residuals.push_back(1);
    typename ReferenceCycle<Real>::Workspace workspace(cycle_, lanes, channels);
    std::vector<Real> previous;
    int cycle = 0;
    for (; cycle < options_.max_cycles && !converged(); ++cycle) {
      progress.check();
      previous = x;
      cycle_.cycle(b.data(), x.data(), workspace);
      add_steps(previous, x, lanes, error);
      now = squared_residual();
      if (!now.allFinite()) throw SolverError("the reference cycle met a value that is not finite");
      if (int(report.residuals.size()) <= cycle + 1) report.residuals.push_back(0);
      double& residual = report.residuals[cycle + 1];
      residual = std::max(residual, worst_ratio(now, before));
      progress.at(std::clamp(std::log(residual) / std::log(options_.tolerance), 0.0, 1.0),
                  fmt::format("residual {:.0e}", residual));
    }
    report.cycles = std::max(report.cycles, cycle);
    report.converged = report.converged && converged();
    for (const ErrorEstimate& e : error) report.error = std::max(report.error, e.relative());
    from_lanes(x, first, channels, lanes, X);
  }

  Stopwatch watch_;  ///< first of all members: it times the making of the others
  ReferenceOptions options_;
  ReferenceCycle<Real> cycle_;
  double setup_seconds_ = 0;
};

}  // namespace

SolverFactory reference_solver(const Texels& texels, const ReferenceOptions& options) {
  return [&texels, options](const SparseMatrix& A,
                            const Progress& progress) -> std::unique_ptr<LinearSolver> {
    if (options.precision == ReferenceOptions::Precision::float32)
      return std::make_unique<ReferenceSolver<float>>(A, texels, options, progress);
    return std::make_unique<ReferenceSolver<double>>(A, texels, options, progress);
  };
}

}  // namespace mq
