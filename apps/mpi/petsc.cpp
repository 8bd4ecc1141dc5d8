#include "petsc.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq::shared {

void check(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw SolverError(fmt::format("PETSc: {} (error {})", text ? text : "unknown error", int(code)));
}

void put_channel(const Signal& X, Eigen::Index channel, Vec to) {
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(to, &values));
  for (Eigen::Index i = 0; i < X.rows(); ++i) values[i] = X(i, channel);
  check(VecRestoreArrayWrite(to, &values));
}

void take_channel(Vec from, Eigen::Index channel, Signal& X) {
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(from, &values));
  for (Eigen::Index i = 0; i < X.rows(); ++i) X(i, channel) = values[i];
  check(VecRestoreArrayRead(from, &values));
}

}  // namespace mq::shared
