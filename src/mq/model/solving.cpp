#include "mq/model/solving.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/words.h"
#include "mq/linear/direct_solver.h"
#include "mq/linear/factorisation_bytes.h"

namespace mq {
namespace {

/// Whether the choice leaves multigrid, and so what follows it, to us.
bool begins_with_multigrid(const SolverChoice& choice, const SignalSpace& space) {
  return choice.kind == SolverChoice::Kind::automatic && space.size() > most_for_factorisation;
}

SolverFactory first_solver(const SolverChoice& choice, const SignalSpace& space) {
  switch (choice.kind) {
    case SolverChoice::Kind::automatic: return space.solver(choice.stop);
    case SolverChoice::Kind::direct: return direct_solver();
    case SolverChoice::Kind::multigrid: return space.multigrid(choice.stop);
    case SolverChoice::Kind::given: return choice.factory;
  }
  return direct_solver();
}

/// Whether iterations went astray: what is missing is a tenth of the solution or more, as far as the last steps tell,
/// and the residual grew a long way after it had been small.
bool diverged(const SolveReport& report) {
  constexpr double large = 0.1, grown = 30;
  double least = std::numeric_limits<double>::infinity(), growth = 0;
  for (const double residual : report.residuals) {
    least = std::min(least, residual);
    growth = std::max(growth, residual / least);
  }
  return !report.converged && report.error >= large && growth > grown;
}

/// The attempt; throws `SolverError` where it diverged, so that nothing of it is kept.
SolveReport tried(const Attempt& attempt, const SolverFactory& factory) {
  SolveReport report = attempt(factory, 0);
  if (diverged(report))
    throw SolverError(fmt::format("{} diverges: after {} its error is about {:.1e} times the largest change",
                                  report.method, counted(report.cycles, "cycle"), report.error));
  return report;
}

/// Whether there is memory for a factorisation; otherwise says so of the result that is kept.
bool can_factorise(const SignalSpace& space, const std::string& what_happened, Messages& messages) {
  const double wanted = factorisation_bytes(space.size()), there = double(available_memory());
  if (wanted <= there) return true;
  messages.warning(fmt::format(
      "{}, and a factorisation would need about {:.1f} GB where {:.1f} GB are free: the result is "
      "less accurate than asked for (the direct solver tries it all the same)",
      what_happened, wanted / 1e9, there / 1e9));
  return false;
}

std::string less_accurate(const std::string& what_happened, const Error& error) {
  return fmt::format("{}; {}: the result is less accurate than asked for", what_happened,
                     error.what());
}

}  // namespace

std::string reached(const SolveReport& report) {
  return fmt::format(
      "{} stopped after {} at a relative residual of {:.1e} and an error of about {:.1e} "
      "of the largest change",
      report.method, counted(report.cycles, "cycle"),
      report.residuals.empty() ? 1 : report.residuals.back(), report.error);
}

SolveOutcome solve_with(const SolverChoice& choice, const SignalSpace& space,
                        const Attempt& attempt, Messages& messages) {
  const bool may_factorise = begins_with_multigrid(choice, space);
  SolveOutcome outcome;
  try {
    outcome.report = tried(attempt, first_solver(choice, space));
  } catch (const SolverError& error) {
    if (!may_factorise || !can_factorise(space, error.what(), messages)) throw;
    messages.remark(std::string(error.what()) + ": factorising instead");
    outcome.tried.push_back({"multigrid", error.what(), {}});
    outcome.report = attempt(direct_solver(), 1);
    return outcome;
  }
  const SolveReport& first = outcome.report;
  if (first.converged) return outcome;
  const std::string what_happened = reached(first);
  if (choice.stop.max_cycles) {
    if (!first.residuals.empty() && first.residuals.back() >= 1)
      messages.warning(what_happened +
                       ": no better than where it began; do not limit its cycles, "
                       "or try the direct solver");
    return outcome;
  }
  if (!may_factorise) {
    messages.warning(what_happened +
                     ": the result is less accurate than asked for; the direct solver "
                     "factorises instead");
    return outcome;
  }
  if (!can_factorise(space, what_happened, messages)) return outcome;
  messages.remark(what_happened + ": factorising instead");
  try {
    SolveReport second = attempt(direct_solver(), 1);
    outcome.tried.push_back({first.method, "", first});
    outcome.report = std::move(second);
  } catch (const SolverError& error) {
    messages.warning(less_accurate(what_happened, error));
  } catch (const OutOfMemory& error) {
    messages.warning(less_accurate(what_happened, error));
  }
  return outcome;
}

}  // namespace mq
