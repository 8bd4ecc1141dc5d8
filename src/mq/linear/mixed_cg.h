#pragma once
/// Conjugate gradients in single precision that solve to double precision.

#include <vector>

#include "mq/linear/multigrid.h"
#include "mq/linear/solver.h"

namespace mq {

/// The unknowns on whose constants a matrix may vanish.
struct Components {
  std::vector<int> component;  ///< per unknown; empty: all are one component
  std::vector<char> singular;  ///< per component: A·1 = 0 there
  std::vector<double> size;    ///< Σ 1/D² over its unknowns (see `Scaling`): their number, nearly

  bool any_singular() const;
};

struct MixedCgOptions {
  double tolerance = 1e-6;  ///< stop when ‖B − A·X‖ ≤ tolerance · ‖B‖ in every channel, and
                            ///< `ErrorEstimate` finds the error small enough
  int max_cycles = 60;
  int least_cycles = 0;  ///< so many before the error is believed to be small: it shows by the steps
};

/// Improves X towards A·X = B, high + low = common · D·A·D, by conjugate gradients around
/// `multigrid`, which approximates the inverse of that.
///
/// Directions, residuals and the cycle are in single precision; X is in double, and the residual is
/// computed anew from X in double whenever it has lost three decimal digits, so that any tolerance
/// a double allows is reached. Channels are served four at a time, each with its own step lengths.
/// On singular components what B holds of constants is dropped and X keeps its mean (in which a
/// row counts 1/D²).
///
/// Hestenes and Stiefel [hestenes1952conjugate]; renewing the residual: van der Vorst and Ye 2000.
SolveReport mixed_conjugate_gradients(const StencilMatrix& high, const StencilMatrix& low,
                                      const Scaling& scaling, const Multigrid& multigrid,
                                      const Components& components, const Signal& B, Signal& X,
                                      const MixedCgOptions& options, const Progress& progress = {});

}  // namespace mq
