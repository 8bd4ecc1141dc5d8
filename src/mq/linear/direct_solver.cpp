#include "mq/linear/direct_solver.h"


#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/residual.h"

namespace mq {

namespace {

class Direct final : public LinearSolver {
 public:
  Direct(const SparseMatrix& A, Factorisation kind, std::int64_t most_entries,
         const Progress& progress)
      : A_(A), solver_(A, kind, progress, most_entries) {
    setup_seconds_ = watch_.seconds();
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    const Stopwatch watch;
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
    report.solve_seconds = watch.seconds();
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    const Stopwatch watch;
    solver_.refactor(A, progress);
    A_ = A;
    setup_seconds_ = watch.seconds();
  }

 private:
  Stopwatch watch_;  ///< first of all members: it times the making of the others
  SparseMatrix A_;
  DirectSolver solver_;
  double setup_seconds_ = 0;
};

}  // namespace

SolverFactory direct_solver(Factorisation kind, std::int64_t most_entries) {
  return [kind, most_entries](const SparseMatrix& A, const Progress& progress) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<Direct>(A, kind, most_entries, progress);
  };
}

}  // namespace mq
