#include "equation.h"

#include <fmt/format.h>

#include "mq/linear/conjugate_gradients.h"
#include "mq/model/solving.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "preconditioners.h"
#include "shell/results.h"

namespace mq::shared {

using app::Run;
using app::Step;

namespace {

constexpr int usual_cycles = 200;

/// Finer than that of one process, so that pictures of any number of processes differ by less than 1e-6.
constexpr double usual_tolerance = 1e-7;

Solver asked_solver(const OptionValues& options) {
  const std::string name = options.text("solver");
  if (name == "bddc") return Solver::bddc;
  return name == "boomeramg" ? Solver::boomeramg : name == "gamg" ? Solver::gamg : Solver::multigrid;
}

}  // namespace

void add_shared_solver_options(OptionTable& table, const std::string& usual_solver,
                               const std::vector<std::string>& further_solvers) {
  std::vector<std::string> solvers{"multigrid", "boomeramg", "gamg"};
  solvers.insert(solvers.end(), further_solvers.begin(), further_solvers.end());
  table.add({.name = "solver",
             .type = Option::Type::choice,
             .default_value = usual_solver,
             .choices = solvers,
             .metavar = "HOW",
             .group = "Solver",
             .help = "what iterations are preconditioned by",
             .details = "multigrid: the cycle of marquetry in every process, and a coarse level that all share. "
                        "boomeramg, gamg: the algebraic multigrids of hypre and PETSc, to compare with. bddc, of "
                        "filter and stitch: PETSc's balancing of subdomains by constraints, to compare with."});
  app::add_stopping_options(table, app::as_typed(usual_tolerance),
                            fmt::format("Else they give up after {}, with a warning.", usual_cycles));
}

SharedEquation::SharedEquation(Run& run, const Processes& processes, const Numbering& numbering, TexelPart& part,
                               double weight)
    : SharedEquation(run, processes, numbering, part, [&](const TexelSpace& space, const Progress& progress) {
        SparseMatrix A = space.regularised_system(1, weight, progress);
        if (asked_solver(run.options()) == Solver::bddc) subdomain_ = Subdomain(part, numbering, A, weight);
        part.let_go_of_space();
        return A;
      }) {}

SharedEquation::SharedEquation(Run& run, const Processes& processes, const Numbering& numbering, const TexelPart& part,
                               const Assemble& assemble)
    : run_(run), processes_(processes), numbering_(numbering), part_(part) {
  const Step step(run, "assemble", 0.2);
  SparseMatrix A;
  processes.together([&] {
    if (part.empty()) return;
    texels_ = part.space().texels();
    A = assemble(part.space(), step);
  });
  processes.talking([&] { matrix_ = std::make_unique<SharedMatrix>(A, processes, part, numbering); });
}

Signal SharedEquation::solve(const Signal& B) {
  Signal X = Signal::Zero(B.rows(), B.cols());
  const double largest = processes_.largest(B.size() > 0 ? B.cwiseAbs().maxCoeff() : 0);
  if (largest == 0) {
    run_.solve = app::solve_json(nothing_to_solve());
    return X;
  }
  const StoppingRule stop = app::stopping_rule(run_.options());
  SolveReport report;
  std::unique_ptr<SharedPreconditioner> preconditioner;
  {
    const Step step(run_, "prepare", 0.2);
    processes_.talking([&] {
      const Solver solver = asked_solver(run_.options());
      preconditioner = solver == Solver::bddc ? bddc(*matrix_, subdomain_)
                                              : make_preconditioner(solver, processes_, *matrix_, numbering_, part_,
                                                                    texels_);
    });
    subdomain_ = {};
    texels_ = {};
  }
  const Step step(run_, "solve", 0.3);
  processes_.talking([&] {
    report = conjugate_gradients(shared_system(*matrix_, processes_), B, X,
                                 [&](const Signal& R, Signal& Z) { preconditioner->apply(R, Z); },
                                 {.tolerance = stop.tolerance,
                                  .max_cycles = stop.max_cycles.value_or(usual_cycles),
                                  .stop = ConjugateGradientOptions::Stop::residual_error});
  });
  report.method = preconditioner->name();
  run_.solve = app::solve_json(report);
  if (!report.converged) run_.terminal().warning(reached(report));
  return X;
}

}  // namespace mq::shared
