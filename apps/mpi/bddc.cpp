// PETSc's BDDC: every process factors what it adds to the matrix, with and without the texels that others add to,
// and a small matrix of means over the borders is solved by all.
//
// Where a border runs along a seam, a process has few of the elements that a texel takes part in. A seam's element
// couples some twenty texels and depends on a few combinations of them: what a process adds is singular, or nearly so,
// with vectors that are far from constant. Two things keep BDDC from breaking there. A little of the diagonal is added,
// to what preconditions alone. And values at borders are averaged by the matrices of both sides (deluxe scaling), not
// by their diagonals: a process has no say in what its own elements do not tell.

#include "preconditioners.h"

namespace mq::shared {
namespace {

/// Of the diagonal, added to what a process adds.
constexpr double shift = 1e-4;

/// Of a process alone.
OwnedMat shifted(const SparseMatrix& A) {
  OwnedMat matrix;
  std::vector<PetscInt> counts, columns;
  for (Eigen::Index i = 0; i < A.rows(); ++i) counts.push_back(A.outerIndexPtr()[i + 1] - A.outerIndexPtr()[i]);
  const auto size = PetscInt(A.rows());
  check(MatCreateSeqAIJ(PETSC_COMM_SELF, size, size, 0, counts.data(), matrix.place()));
  std::vector<PetscScalar> values;
  for (PetscInt i = 0; i < size; ++i) {
    columns.clear(), values.clear();
    for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
      columns.push_back(PetscInt(entry.col()));
      values.push_back(entry.value() * (entry.col() == i ? 1 + shift : 1));
    }
    check(MatSetValues(matrix, 1, &i, PetscInt(columns.size()), columns.data(), values.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

void set_default(const char* option, const char* value) {
  PetscBool is_set = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, option, &is_set));
  if (!is_set) check(PetscOptionsSetValue(nullptr, option, value));
}

class BalancingByConstraints final : public SharedPreconditioner {
 public:
  BalancingByConstraints(const SharedMatrix& matrix, const Subdomain& subdomain) : matrix_(matrix) {
    const std::vector<PetscInt> numbers(subdomain.numbers.begin(), subdomain.numbers.end());
    ISLocalToGlobalMapping map = nullptr;
    check(ISLocalToGlobalMappingCreate(PETSC_COMM_WORLD, 1, PetscInt(numbers.size()), numbers.data(),
                                       PETSC_COPY_VALUES, &map));
    const auto rows = PetscInt(matrix.own_rows());
    check(MatCreateIS(PETSC_COMM_WORLD, 1, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, map, map, sum_.place()));
    check(ISLocalToGlobalMappingDestroy(&map));
    check(MatISSetLocalMat(sum_, shifted(subdomain.matrix)));
    check(MatAssemblyBegin(sum_, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(sum_, MAT_FINAL_ASSEMBLY));
    check(MatSetOption(sum_, MAT_SPD, PETSC_TRUE));
    set_default("-pc_bddc_use_deluxe_scaling", "true");
    // As one matrix, not one for each piece of a border: each costs messages, and seams make many.
    set_default("-pc_bddc_deluxe_singlemat", "true");
    // In per cent: MUMPS thinks too little of what small matrices want.
    set_default("-sub_schurs_mat_mumps_icntl_14", "400");
    check(PCCreate(PETSC_COMM_WORLD, pc_.place()));
    check(PCSetType(pc_, PCBDDC));
    check(PCSetOperators(pc_, sum_, sum_));
    check(PCSetFromOptions(pc_));
    check(PCSetUp(pc_));
  }

  void apply(const Signal& R, Signal& Z) const override {
    matrix_.for_each_channel(R, Z, [&](Vec r, Vec z) { check(PCApply(pc_, r, z)); });
  }

  std::string name() const override { return "conjugate gradients, BDDC (PETSc)"; }

 private:
  const SharedMatrix& matrix_;
  OwnedMat sum_;
  OwnedPC pc_;
};

}  // namespace

std::unique_ptr<SharedPreconditioner> bddc(const SharedMatrix& matrix, const Subdomain& subdomain) {
  return std::make_unique<BalancingByConstraints>(matrix, subdomain);
}

}  // namespace mq::shared
