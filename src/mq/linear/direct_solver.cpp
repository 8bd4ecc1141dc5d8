#include "mq/linear/direct_solver.h"

#include <chrono>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/linear/residual.h"

namespace mq {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class Direct final : public LinearSolver {
 public:
  Direct(const SparseMatrix& A, Factorisation kind, const Progress& progress)
      : A_(A), solver_(A, kind, progress) {
    setup_seconds_ = seconds_since(start_);
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    const auto start = Clock::now();
    require(B.rows() == A_.rows() && X.rows() == B.rows() && X.cols() == B.cols(),
            fmt::format("a system of {} rows was given a right-hand side of {} × {} and a first "
                        "guess of {} × {}", A_.rows(), B.rows(), B.cols(), X.rows(), X.cols()));
    SolveReport report;
    report.method = "direct (" + solver_.name() + ")";
    report.setup_seconds = setup_seconds_;
    const Signal R = residual(A_, X, B);
    const Eigen::RowVectorXd before = channel_dots(R, R);
    if (!before.allFinite())
      throw SolverError("the right-hand side or the first guess holds a value that is not finite");
    if ((before.array() > 0).any()) {
      X += solver_.solve(R, progress);
      const Signal after = residual(A_, X, B);
      report.cycles = 1;
      report.residuals = {1, worst_ratio(channel_dots(after, after), before)};
      if (!X.allFinite())
        throw SolverError("the solution is not finite: the matrix is singular to working precision");
    }
    report.solve_seconds = seconds_since(start);
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    const auto start = Clock::now();
    solver_.refactor(A, progress);
    A_ = A;
    setup_seconds_ = seconds_since(start);
  }

 private:
  Clock::time_point start_ = Clock::now();
  SparseMatrix A_;
  DirectSolver solver_;
  double setup_seconds_ = 0;
};

}  // namespace

SolverFactory direct_solver(Factorisation kind) {
  return [kind](const SparseMatrix& A, const Progress& progress) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<Direct>(A, kind, progress);
  };
}

}  // namespace mq
