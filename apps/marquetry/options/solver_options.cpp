#include "options/solver_options.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/baseline/reference_solver.h"
#include "mq/base/release.h"
#include "mq/model/kept_work.h"
#include "mq/model/packed_pictures.h"

namespace mq::app {
void add_solver_options(OptionTable& table, const std::string& tolerance) {
  using Type = Option::Type;
  table.add(
      {.name = "solver",
       .type = Type::choice,
       .default_value = "automatic",
       .choices = {"automatic", "direct", "multigrid", "reference"},
       .metavar = "HOW",
       .group = "Solver",
       .help = "automatic, direct, multigrid or reference",
       .details =
           "direct: a factorisation. multigrid: iterations, with far less memory on "
           "large textures. automatic: direct up to 30,000 unknowns, multigrid "
           "above, where there is one, and direct again where that does not reach the tolerance "
           "and memory allows. reference: the multigrid solver as it was published, in double "
           "precision, to compare with."});
  add_stopping_options(table, tolerance,
                       "Else multigrid gives up after 60 and reference after 200, with a warning; with "
                       "this, automatic does not factorise where the tolerance was not reached.");
}

void add_stopping_options(OptionTable& table, const std::string& tolerance, const std::string& without_cycles) {
  using Type = Option::Type;
  table.add({.name = "tolerance",
             .type = Type::number,
             .default_value = tolerance,
             .least = 1e-16,
             .most = 0.1,
             .group = "Solver",
             .help = "relative residual at which iterations stop",
             .details = std::string(
                            "And their error as their last steps tell it: four times this, "
                            "relative to the largest change.") +
                        (tolerance == as_typed(StoppingRule{}.tolerance)
                             ? " By default a quarter of a step of 16 bits "
                               "where values change from 0 to 1."
                             : "")});
  table.add({.name = "cycles",
             .type = Type::integer,
             .least = 1,
             .most = 10000,
             .group = "Solver",
             .help = "stop iterations after so many cycles, converged or not",
             .details = without_cycles});
}

StoppingRule stopping_rule(const OptionValues& options) {
  StoppingRule stop{.tolerance = options.number("tolerance")};
  if (options.has("cycles")) stop.max_cycles = int(options.integer("cycles"));
  return stop;
}

SolverChoice solver_choice(const OptionValues& options, const ModelSignal& signal) {
  using Kind = SolverChoice::Kind;
  SolverChoice choice{.stop = stopping_rule(options)};
  const std::string name = options.text("solver");
  choice.kind = name == "direct"      ? Kind::direct
                : name == "multigrid" ? Kind::multigrid
                : name == "reference" ? Kind::given
                                      : Kind::automatic;
  if (choice.kind == Kind::given) {
    if (signal.texel_space() == nullptr)
      throw Unsupported("--solver reference is for textures; use direct or multigrid at vertices");
    choice.factory = reference_solver(signal.texel_space()->texels(),
                                      stopping<ReferenceOptions>(choice.stop));
  }
  return choice;
}

namespace {

SolveReport solve_by_choice(Run& run, const ModelSignal& signal, const TimedAttempt& attempt) {
  const SolveOutcome outcome = solve_with(
      solver_choice(run.options(), signal), signal.space(),
      [&](const SolverFactory& factory, int retry) {
        return attempt(factory,
                       retry == 0 ? SolvingShares{} : SolvingShares{.prepare = 0.08, .solve = 0.02});
      },
      run.terminal());
  run.solve = solve_json(outcome.report);
  run.solve["tried"] = Json::array();
  for (const SolveOutcome::Tried& tried : outcome.tried)
    run.solve["tried"].push_back(tried.error.empty()
                                     ? solve_json(tried.report)
                                     : Json{{"method", tried.method}, {"error", tried.error}});
  // Who asks for few cycles gets them, and is told how far they came; without --cycles what solves says it.
  const SolveReport& solved = outcome.report;
  if (run.options().has("cycles") && !solved.converged && !solved.residuals.empty() && solved.residuals.back() < 1)
    run.terminal().remark(reached(solved) + ": more --cycles come nearer");
  return outcome.report;
}

}  // namespace

SolveReport solve_as_asked(Run& run, const ModelSignal& signal, const TimedAttempt& attempt) {
  if (run.kept) run.kept->forget_equation();  // this one is another, and needs the memory
  return solve_by_choice(run, signal, attempt);
}

namespace {

/// The equation of an attempt, kept from before or made.
KeptWork::Equation prepared(Run& run, const ModelSignal& signal, const SignalSpace& space, double weight,
                            const SolverFactory& factory, bool first, double share) {
  const Step step(run, "prepare", share);
  if (run.kept && first) return run.kept->equation(space, weight, solver_choice(run.options(), signal), factory, step);
  return {std::make_shared<const ScreenedPoisson>(space, weight, factory, step)};
}

/// The same solvers; a space lets go of its integrals between the assembly of the matrix and the rest of the work.
SolverFactory letting_go(const TexelSpace& space, const SolverFactory& factory) {
  if (!factory.takes_stencils()) return factory;
  return {SolverFactory::OfMatrix(factory), [&space, factory](StencilSystem&& A, const Progress& progress) {
            space.let_go_of_integrals();
            try {
              return factory(std::move(A), progress);
            } catch (const NotPositiveDefinite&) {
              space.integrate_again();
              throw;
            }
          }};
}

}  // namespace

Solution solve_poisson(Run& run, const ModelSignal& signal, const SignalSpace& space, double weight,
                       const PoissonSolve& solve) {
  Solution solution;
  KeptWork::Equation equation;
  int attempts = 0;
  solve_by_choice(run, signal, [&](const SolverFactory& factory, const SolvingShares& shares) {
    equation = prepared(run, signal, space, weight, factory, attempts++ == 0, shares.prepare);
    const Step step(run, "solve", shares.solve);
    if (solution.before.size() == 0) solution.before = signal.values();
    solution.filtered = solve(*equation.of, solution.before, step);
    return solution.filtered.report;
  });
  if (run.kept) run.kept_equation = equation.kept;
  return solution;
}

Solution solve_in_steps(Run& run, Model& model, const ModelSignal& signal, double weight, const PoissonSteps& steps) {
  const TexelSpace* const lean = run.kept ? nullptr : signal.texel_space();
  Solution solution;
  int attempts = 0;
  solve_by_choice(run, signal, [&](const SolverFactory& factory, const SolvingShares& shares) {
    release(solution.before);
    if (lean) lean->integrate_again();
    steps.begin(signal.values());
    {
      const PackedPictures packed(model);
      const KeptWork::Equation equation =
          prepared(run, signal, signal.space(), weight, lean ? letting_go(*lean, factory) : factory, attempts++ == 0,
                   shares.prepare);
      run.kept_equation = equation.kept;
      if (lean) lean->let_go_of_texels();
      const Step step(run, "solve", shares.solve);
      solution.filtered.report = steps.solve(*equation.of, step);
    }
    if (lean) lean->place_again();
    solution.before = signal.values();
    solution.filtered.signal = steps.end(solution.before);
    return solution.filtered.report;
  });
  return solution;
}

void report_solve_at_seams(Run& run, const SolveReport& report) {
  run.solve = solve_json(report);
  if (!report.converged)
    run.terminal().warning(reached(report) + ": seams may be left where a lower --weight has none");
}

namespace {

struct ValueChanges {
  double squares = 0, largest = 0;
  std::int64_t below = 0, above = 0;

  friend ValueChanges operator+(const ValueChanges& a, const ValueChanges& b) {
    return {a.squares + b.squares, std::max(a.largest, b.largest), a.below + b.below, a.above + b.above};
  }
};

ValueChanges value_changes(const double* before, const double* after, std::int64_t count, double white) {
  ValueChanges found;
  for (std::int64_t i = 0; i < count; ++i) {
    const double change = std::abs(after[i] - before[i]);
    found.squares += change * change;
    found.largest = std::max(found.largest, change);
    found.below += after[i] < 0;
    found.above += after[i] > white;
  }
  return found;
}

}  // namespace

Json change_json(const Signal& before, const Signal& after, ColourSpace space) {
  // Neither curve moves 0, and light's has 1 where display values have it.
  const double white = space == ColourSpace::log ? log_from_linear(1) : 1;
  const ValueChanges found = parallel_sum(after.size(), ValueChanges{}, [&](std::int64_t begin, std::int64_t end) {
    return value_changes(before.data() + begin, after.data() + begin, end - begin, white);
  });
  const double count = double(std::max<Eigen::Index>(1, after.size()));
  return {{"unknowns", before.rows()},
          {"channels", before.cols()},
          {"rms_change", std::sqrt(found.squares / count)},
          {"largest_change", found.largest},
          {"below_0", found.below},
          {"above_1", found.above},
          {"beyond_percent", 100 * double(found.below + found.above) / count}};
}

Json solve_json(const SolveReport& report) {
  return {{"method", report.method},
          {"cycles", report.cycles},
          {"residuals", report.residuals},
          {"error", report.error},
          {"converged", report.converged}};
}

}  // namespace mq::app
