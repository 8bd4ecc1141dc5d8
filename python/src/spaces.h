#pragma once
/// Signal spaces as Python holds them: with the surface and the atlas that they refer to.

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "arrays.h"
#include "mq/fem/space.h"
#include "mq/linear/solver.h"

namespace mq::python {

using Space = std::shared_ptr<SignalSpace>;

/// "automatic", "direct" or "multigrid"; cycles 0: the solver's own limit.
struct Solving {
  std::string how = "automatic";
  double tolerance = 1e-6;
  int cycles = 0;
};

/// Throws `InvalidInput` for another word and a tolerance that is not positive.
SolverFactory factory_of(const SignalSpace& space, const Solving& solving);

/// {"method", "cycles", "residuals", "converged", "error", "setup_seconds", "solve_seconds"}
py::dict report_of(const SolveReport& report);

}  // namespace mq::python
