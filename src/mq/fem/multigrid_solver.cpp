#include "mq/fem/multigrid_solver.h"


#include <fmt/format.h>

#include "mq/base/stopwatch.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {

namespace {

class MultigridSolver final : public LinearSolver {
 public:
  MultigridSolver(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options,
                  const Progress& progress)
      : hierarchy_(A, texels, options, progress),
        options_{options.tolerance, options.max_cycles} {
    setup_seconds_ = watch_.seconds();
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    require(B.rows() == hierarchy_.rows() && X.rows() == B.rows() && X.cols() == B.cols(),
            fmt::format("a system of {} rows was given a right-hand side of {} × {} and a first "
                        "guess of {} × {}", hierarchy_.rows(), B.rows(), B.cols(), X.rows(),
                        X.cols()));
    SolveReport report;
    if (B.size() > 0)
      report = mixed_conjugate_gradients(hierarchy_.high(), hierarchy_.low(), hierarchy_.scaling(),
                                         hierarchy_.multigrid(), hierarchy_.components(), B, X,
                                         options_, progress);
    report.method = "multigrid";
    report.setup_seconds = setup_seconds_;
    return report;
  }

  void update(const SparseMatrix& A, const Progress& progress) override {
    const Stopwatch watch;
    hierarchy_.set_values(A, progress);
    setup_seconds_ = watch.seconds();
  }

 private:
  Stopwatch watch_;  ///< first of all members: it times the making of the others
  TexelHierarchy hierarchy_;
  MixedCgOptions options_;
  double setup_seconds_ = 0;
};

}  // namespace

SolverFactory multigrid_solver(const Texels& texels, const MultigridOptions& options) {
  return [&texels, options](const SparseMatrix& A,
                            const Progress& progress) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<MultigridSolver>(A, texels, options, progress);
  };
}

}  // namespace mq
