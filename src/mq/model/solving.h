#pragma once
/// How equations on a model are solved: with the solver that was asked for or that fits the space, and
/// with another where that one does not get there.

#include <functional>
#include <string>
#include <vector>

#include "mq/fem/space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/model/messages.h"
#include "mq/model/model_signal.h"

namespace mq {

struct SolverChoice {
  enum class Kind {
    automatic,  ///< `SignalSpace::solver`, and a factorisation where that does not get there
    direct,     ///< a factorisation
    multigrid,  ///< `SignalSpace::multigrid`
    given       ///< `factory`
  } kind = Kind::automatic;
  SolverFactory factory = {};
  StoppingRule stop = {};
};

/// One solution with solvers of this factory. `retry` is 0 for the first attempt: set-ups of later ones
/// take longer.
using Attempt = std::function<SolveReport(const SolverFactory& factory, int retry)>;

/// What came of the attempts.
struct SolveOutcome {
  SolveReport report;  ///< of the attempt whose result stands: the last that came back

  /// An attempt before it, given up.
  struct Tried {
    std::string method;
    std::string error;   ///< what it threw; empty: it came back and fell short
    SolveReport report;  ///< if it came back
  };
  std::vector<Tried> tried;
};

/// Solves by the choice. With `automatic`, where multigrid throws or falls short of the tolerance, a
/// factorisation follows if there is memory for it. Where the choice limits cycles, what they reach
/// stands, and falling short is in the report alone; iterations that diverged count as thrown. Without a
/// limit a warning says what falls short of the tolerance. Throws what the last attempt throws.
SolveOutcome solve_with(const SolverChoice& choice, const SignalSpace& space,
                        const Attempt& attempt, Messages& messages);

/// "multigrid stopped after 60 cycles at a relative residual of ..."
std::string reached(const SolveReport& report);

}  // namespace mq
