#pragma once
/// A solver for matrices of which nobody knows beforehand whether they can be factored.

#include "mq/linear/conjugate_gradients.h"
#include "mq/linear/solver.h"

namespace mq {

struct EconomicalOptions {
  /// Entries of the factor per entry of A up to which a factorisation is worth it. A strip along
  /// seams needs five or so, a plane of a million points fifteen; where everything meets
  /// everything, there are hundreds.
  double most_fill = 40;
  ConjugateGradientOptions iterate = {.tolerance = 1e-8, .max_cycles = 20000};
};

/// `direct_solver` where the analysis finds that the factor stays within `most_fill` and fits into
/// memory, `conjugate_gradient_solver` otherwise. The report's method says which. A symmetric
/// positive definite.
SolverFactory economical_solver(EconomicalOptions options = {});

}  // namespace mq
