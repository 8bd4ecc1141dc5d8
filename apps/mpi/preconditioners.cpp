#include "preconditioners.h"

namespace mq::shared {
namespace {

class AlgebraicMultigrid final : public SharedPreconditioner {
 public:
  AlgebraicMultigrid(Solver solver, const SharedMatrix& matrix)
      : matrix_(matrix), is_hypre_(solver == Solver::boomeramg) {
    check(PCCreate(PETSC_COMM_WORLD, pc_.place()));
    check(PCSetType(pc_, is_hypre_ ? PCHYPRE : PCGAMG));
    if (is_hypre_) check(PCHYPRESetType(pc_, "boomeramg"));
    check(PCSetOperators(pc_, matrix.matrix(), matrix.matrix()));
    check(PCSetFromOptions(pc_));
    check(PCSetUp(pc_));
  }

  void apply(const Signal& R, Signal& Z) const override {
    matrix_.for_each_channel(R, Z, [&](Vec r, Vec z) { check(PCApply(pc_, r, z)); });
  }

  std::string name() const override {
    return is_hypre_ ? "conjugate gradients, BoomerAMG (hypre)" : "conjugate gradients, GAMG (PETSc)";
  }

 private:
  const SharedMatrix& matrix_;
  OwnedPC pc_;
  bool is_hypre_;
};

}  // namespace

std::unique_ptr<SharedPreconditioner> algebraic_multigrid(Solver solver, const SharedMatrix& matrix) {
  return std::make_unique<AlgebraicMultigrid>(solver, matrix);
}

std::unique_ptr<SharedPreconditioner> make_preconditioner(Solver solver, const Processes& processes,
                                                          const SharedMatrix& matrix, const Numbering& numbering,
                                                          const TexelPart& part, const Texels& texels) {
  if (solver == Solver::multigrid) return schwarz_multigrid(processes, matrix, numbering, part, texels);
  return algebraic_multigrid(solver, matrix);
}

}  // namespace mq::shared
