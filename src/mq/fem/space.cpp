#include "mq/fem/space.h"

#include "mq/linear/direct_solver.h"

namespace mq {

SolverFactory SignalSpace::solver(const StoppingRule& stop) const {
  return size() <= most_for_factorisation ? direct_solver() : multigrid(stop);
}

SolverFactory solver_or_own(const SolverFactory& given, const SignalSpace& space) {
  return given ? given : space.solver();
}

}  // namespace mq
