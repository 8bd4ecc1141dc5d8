#include "direct_system.h"

#include <fmt/format.h>

#include <limits>

#include "mq/base/error.h"

namespace mq::shared {

DirectSystem::DirectSystem(const Processes& processes, int count,
                           const std::function<std::vector<RowEntry>(int)>& row) {
  std::vector<double> counts(std::size_t(processes.count()), 0);
  counts[std::size_t(processes.rank())] = count;
  processes.sum(counts);
  std::int64_t first = 0;
  for (std::size_t p = 0; p < counts.size(); ++p) {
    if (int(p) < processes.rank()) first += std::int64_t(counts[p]);
    total_ += std::int64_t(counts[p]);
  }
  require(total_ < std::numeric_limits<PetscInt>::max(),
          fmt::format("{} texels are to be solved for, more than this build of PETSc counts: build with one that has "
                      "64-bit indices (libpetsc64-real-dev)",
                      total_));
  if (total_ == 0) return;
  std::vector<PetscInt> own(std::size_t(count), 0), others(std::size_t(count), 0);
  for (int k = 0; k < count; ++k)
    for (const RowEntry& entry : row(k))
      ++(entry.column >= first && entry.column < first + count ? own : others)[std::size_t(k)];
  check(MatCreateAIJ(PETSC_COMM_WORLD, count, count, PetscInt(total_), PetscInt(total_), 0, own.data(), 0,
                     others.data(), matrix_.place()));
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  for (int k = 0; k < count; ++k)
    for (const RowEntry& entry : row(k))
      check(MatSetValue(matrix_, PetscInt(first + k), PetscInt(entry.column), entry.value, INSERT_VALUES));
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix_, MAT_SPD, PETSC_TRUE));
  check(MatCreateVecs(matrix_, x_.place(), b_.place()));
  check(PCCreate(PETSC_COMM_WORLD, factor_.place()));
  check(PCSetType(factor_, PCCHOLESKY));
  check(PCFactorSetMatSolverType(factor_, MATSOLVERMUMPS));
  check(PCSetOperators(factor_, matrix_, matrix_));
  check(PCSetFromOptions(factor_));
  check(PCSetUp(factor_));
}

Signal DirectSystem::solve(const Signal& B) const {
  Signal X = Signal::Zero(B.rows(), B.cols());
  if (total_ == 0) return X;
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    put_channel(B, c, b_);
    check(PCApply(factor_, b_, x_));
    take_channel(x_, c, X);
  }
  return X;
}

}  // namespace mq::shared
