#pragma once
/// Positive solutions that fall by hundreds of orders of magnitude, with every ratio accurate.

#include <utility>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/shared_unknowns.h"
#include "mq/linear/matrix.h"

namespace mq {

struct HeatSweepOptions {
  double tolerance =
      1e-4;  ///< stop when Σ_j a_ij u_j / u_i is this near to 1, on average; above 1e-8. Or
             ///< when within ten times that it gets no nearer: by less than a twentieth in ten
             ///< sweeps, after twenty
  int max_sweeps = 200;
};

struct HeatSweeps {
  Vector log_u;  ///< −∞ where no coupling leads to a fixed unknown
  int sweeps = 0;
  double change = 0;  ///< mean of |log Σ_j a_ij u_j / u_i| in the last of them, rows that never fit
                      ///< counting for 100 tolerances: there is none where u is not positive
};

/// log u for A·u = 0 in every row but those of `fixed` (unknown and the value of log u there),
/// where A is symmetric with positive row sums and mostly negative couplings: M + t·S with M
/// lumped.
///
/// u falls by a factor e every √t. A solver that is accurate in a norm gets the first dozen of them
/// right, and after 700 there is no number of double precision left. Here the logarithm is kept.
/// With a_ij = −A_ij/A_ii a sweep finds by how much each row misses,
///
///     c_i = log Σ_j a_ij u_j / u_i,
///
/// and carries that along, in the order of falling u: log u_i += 0.8 δ_i with
///
///     δ_i = c_i + Σ_nearer a_ij u_j δ_j / Σ_nearer a_ij u_j        ("nearer": u_j > u_i).
///
/// So an amplitude crosses the whole surface in one sweep, and what is left to later ones are the
/// ratios of neighbours, which depend on little beyond √t. Where rows miss because couplings
/// have the wrong sign (triangles stretched beyond √2 have such), the first sweeps are bounded.
///
/// `guess` is where to begin, finite where couplings lead from a fixed unknown; empty: from a crude
/// one.
///
/// Costs about 100 ns per unknown and sweep on one thread, 20 sweeps for t of a few squared
/// spacings, more for longer t. The same bits for any number of threads.
HeatSweeps sweep_heat(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed,
                      const HeatSweepOptions& options = {}, const Vector& guess = {},
                      const Progress& progress = {});

/// The same for one of several processes: `fixed` are its own, `guess`, which must be given, is where to begin; what it
/// leaves infinite is not reached. Sweeps are those of one process, all unknowns in one order, but for a millionth of what
/// rows miss.
HeatSweeps sweep_heat(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed,
                      const HeatSweepOptions& options, const Vector& guess, const SharedUnknowns& shared,
                      const Progress& progress = {});

}  // namespace mq
