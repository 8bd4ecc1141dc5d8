#include "solving.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "shell/memory.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/words.h"

namespace mq::app {
namespace {

/// Above so many unknowns a factorisation takes several times as long as multigrid, and more
/// memory.
constexpr int most_for_direct = 30'000;

/// A quarter of it, in values from 0 to 1: the tolerance that most verbs have.
constexpr const char* step_of_16_bits = "1e-6";

/// What --solver automatic begins with.
bool begins_with_multigrid(const Domain& domain) {
  return domain.has_multigrid() && domain.space().size() > most_for_direct;
}

SolverFactory solver(const OptionValues& options, const Domain& domain) {
  const std::string name = options.text("solver");
  if (name == "multigrid" || (name == "automatic" && begins_with_multigrid(domain)))
    return domain.multigrid(when_to_stop(options));
  if (name == "reference") return domain.reference(when_to_stop(options));
  return direct_solver();
}

std::string reached(const SolveReport& report) {
  return fmt::format(
      "{} stopped after {} at a relative residual of {:.1e} and an error of about {:.1e} "
      "of the largest change",
      report.method, counted(report.cycles, "cycle"),
      report.residuals.empty() ? 1 : report.residuals.back(), report.error);
}

/// Whether there is memory for a factorisation; otherwise says so of the result that is kept.
bool can_factorise(Run& run, const Domain& domain, const std::string& what_happened) {
  const double wanted = factorisation_bytes(domain.space().size()),
               there = double(available_memory());
  if (wanted <= there) return true;
  run.terminal().warning(fmt::format(
      "{}, and a factorisation would need about {:.1f} GB where {:.1f} GB are free: the result is "
      "less accurate than asked for (--solver direct tries it all the same)",
      what_happened, wanted / 1e9, there / 1e9));
  return false;
}

std::string less_accurate(const std::string& what_happened, const Error& error) {
  return fmt::format("{}; {}: the result is less accurate than asked for", what_happened,
                     error.what());
}

SolveReport solve_and_fall_back(Run& run, const Domain& domain, const Attempt& attempt,
                                Json& tried) {
  const bool free_to_choose =
      run.options().text("solver") == "automatic" && begins_with_multigrid(domain);
  SolveReport first;
  try {
    first = attempt(solver(run.options(), domain), {});
  } catch (const SolverError& error) {
    if (!free_to_choose || !can_factorise(run, domain, error.what())) throw;
    run.terminal().remark(std::string(error.what()) + ": factorising instead");
    tried.push_back({{"method", "multigrid"}, {"error", error.what()}});
    return attempt(direct_solver(), {.prepare = 0.08, .solve = 0.02});
  }
  if (first.converged) return first;
  const std::string what_happened = reached(first);
  if (run.options().has("cycles")) {
    if (!first.residuals.empty() && first.residuals.back() >= 1)
      run.terminal().warning(what_happened +
                             ": no better than where it began; leave --cycles out, "
                             "or try --solver direct");
    return first;
  }
  if (!free_to_choose) {
    run.terminal().warning(what_happened +
                           ": the result is less accurate than asked for; --solver direct "
                           "factorises instead");
    return first;
  }
  if (!can_factorise(run, domain, what_happened)) return first;
  run.terminal().remark(what_happened + ": factorising instead");
  try {
    const SolveReport second = attempt(direct_solver(), {.prepare = 0.08, .solve = 0.02});
    tried.push_back(solve_json(first));
    return second;
  } catch (const SolverError& error) {
    run.terminal().warning(less_accurate(what_happened, error));
  } catch (const OutOfMemory& error) {
    run.terminal().warning(less_accurate(what_happened, error));
  }
  return first;
}

}  // namespace

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
                        (tolerance == step_of_16_bits ? " By default a quarter of a step of 16 bits "
                                                   "where values change from 0 to 1."
                                                 : "")});
  table.add({.name = "cycles",
             .type = Type::integer,
             .least = 1,
             .most = 10000,
             .group = "Solver",
             .help = "stop iterations after so many cycles, converged or not",
             .details =
                 "Else multigrid gives up after 60 and reference after 200, with a warning; with "
                 "this, automatic does not factorise where the tolerance was not reached."});
}

WhenToStop when_to_stop(const OptionValues& options) {
  WhenToStop when{.tolerance = options.number("tolerance")};
  if (options.has("cycles")) when.cycles = int(options.integer("cycles"));
  return when;
}

SolveReport solve_as_asked(Run& run, const Domain& domain, const Attempt& attempt) {
  Json tried = Json::array();
  SolveReport report = solve_and_fall_back(run, domain, attempt, tried);
  run.solve = solve_json(report);
  run.solve["tried"] = tried;
  return report;
}

Solution solve_poisson(Run& run, const Target& target, double weight, const PoissonSolve& solve) {
  Solution solution;
  solve_as_asked(
      run, target.domain(), [&](const SolverFactory& factory, const SolvingShares& shares) {
        std::unique_ptr<ScreenedPoisson> equation;
        {
          const Step step(run, "prepare", shares.prepare);
          equation = std::make_unique<ScreenedPoisson>(target.space(), weight, factory, step);
        }
        const Step step(run, "solve", shares.solve);
        if (solution.before.size() == 0) solution.before = target.values();
        solution.filtered = solve(*equation, solution.before, step);
        return solution.filtered.report;
      });
  return solution;
}

Signal solve_at_seams(Run& run, const TexelSpace& space, const Signal& before,
                      const std::vector<char>& free, Smooth what, const Progress& progress) {
  Filtered found = smooth_at_seams(space, before, free, what, economical_solver(), progress);
  run.solve = solve_json(found.report);
  if (!found.report.converged)
    run.terminal().warning(reached(found.report) +
                           ": seams may be left where a lower --weight has none");
  return std::move(found.signal);
}

Json change_json(const Signal& before, const Signal& after, ColourSpace space) {
  // Neither curve moves 0, and light's has 1 where display values have it.
  const double white = space == ColourSpace::log ? log_from_linear(1) : 1;
  const Signal change = after - before;
  const double count = double(std::max<Eigen::Index>(1, change.size()));
  return {{"unknowns", before.rows()},
          {"channels", before.cols()},
          {"rms_change", std::sqrt(change.squaredNorm() / count)},
          {"largest_change", change.size() ? change.cwiseAbs().maxCoeff() : 0.0},
          {"below_0", (after.array() < 0).count()},
          {"above_1", (after.array() > white).count()}};
}

Json solve_json(const SolveReport& report) {
  return {{"method", report.method},
          {"cycles", report.cycles},
          {"residuals", report.residuals},
          {"error", report.error},
          {"converged", report.converged}};
}

}  // namespace mq::app
