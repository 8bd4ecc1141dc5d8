#pragma once
/// How a verb solves its equations: with the solver that the options ask for or that fits the
/// domain, and with another where that one does not get there.

#include <functional>

#include "mq/filter/screened_poisson.h"
#include "mq/filter/seam_values.h"
#include "mq/model/solving.h"
#include "shell/arguments.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --solver, --tolerance (with this default) and --cycles.
void add_solver_options(OptionTable& table,
                        const std::string& tolerance = as_typed(StoppingRule{}.tolerance));

/// Adds --tolerance and --cycles alone; `without_cycles` says what limits iterations without the latter.
void add_stopping_options(OptionTable& table, const std::string& tolerance, const std::string& without_cycles);

StoppingRule stopping_rule(const OptionValues& options);
SolverChoice solver_choice(const OptionValues& options, const ModelSignal& signal);

/// Shares of a run's progress.
struct SolvingShares {
  double prepare = 0.29;
  double solve = 0.33;
};

/// One solution with solvers of this factory, as steps of the run with these shares.
using TimedAttempt = std::function<SolveReport(const SolverFactory& factory, const SolvingShares&)>;

/// `solve_with` what the options ask for; fills in `run.solve`. Returns the report of the attempt whose
/// result stands.
SolveReport solve_as_asked(Run& run, const ModelSignal& signal, const TimedAttempt& attempt);

/// A signal of the model before and after a screened Poisson equation.
struct Solution {
  Signal before;
  Filtered filtered;
};

/// What to solve for once the solver stands: `equation.solve(...)` or `solve_towards(...)`.
using PoissonSolve = std::function<Filtered(const ScreenedPoisson& equation, const Signal& before,
                                            const Progress& progress)>;

/// `solve_as_asked` of a screened Poisson equation on a space with the signal's unknowns, its own or one in which
/// distances are others. The signal is taken once the solver stands, whose making needs most memory.
Solution solve_poisson(Run& run, const ModelSignal& signal, const SignalSpace& space, double weight,
                       const PoissonSolve& solve);

/// The steps of a solution, see `SolveInSteps`.
struct PoissonSteps {
  std::function<void(Signal before)> begin;
  std::function<SolveReport(const ScreenedPoisson& equation, const Progress& progress)> solve;
  std::function<Signal(const Signal& before)> end;
};

/// `solve_as_asked` of a screened Poisson equation on the signal's own space, in as little memory as it can be had, unless a
/// later run is to have the space: what the solver is not made of is let go of before it is made, and of the model's
/// pictures and the space hardly anything is there while it solves.
Solution solve_in_steps(Run& run, Model& model, const ModelSignal& signal, double weight, const PoissonSteps& steps);

/// What `smooth_at_seams`, which chooses its own solver, did, in `run.solve`; warns where it fell short.
void report_solve_at_seams(Run& run, const SolveReport& report);

/// Unknowns, channels, how much changed in the values of `space`, and how many values are below 0 and
/// above 1 as they will be stored.
Json change_json(const Signal& before, const Signal& after,
                 ColourSpace space = ColourSpace::stored);

Json solve_json(const SolveReport& report);

}  // namespace mq::app
