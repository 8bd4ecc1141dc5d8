#pragma once
/// What conjugate gradients over several processes are preconditioned by.

#include <memory>
#include <string>
#include <vector>

#include "mq/linear/conjugate_gradients.h"
#include "shared_matrix.h"
#include "subdomain.h"

namespace mq::shared {

enum class Solver {
  multigrid,  ///< our cycle in every process, over what it owns and a rim around that, and a coarse level for all
  boomeramg,  ///< hypre's
  gamg,       ///< PETSc's
  bddc        ///< PETSc's, of a matrix that is known as a sum over processes
};

class SharedPreconditioner {
 public:
  virtual ~SharedPreconditioner() = default;
  /// Z ≈ A⁻¹·R of the own rows. Every process must call it.
  virtual void apply(const Signal& R, Signal& Z) const = 0;
  /// For the report.
  virtual std::string name() const = 0;
};

/// Any but BDDC. Every process must call it; the matrix must outlive the preconditioner. `texels` are those of the
/// part's space, taken before that was let go of: they say where the own texels lie.
std::unique_ptr<SharedPreconditioner> make_preconditioner(Solver solver, const Processes& processes,
                                                          const SharedMatrix& matrix, const Numbering& numbering,
                                                          const TexelPart& part, const Texels& texels);

/// hypre's or PETSc's, by the name of its kind.
std::unique_ptr<SharedPreconditioner> algebraic_multigrid(Solver solver, const SharedMatrix& matrix);

/// The additive one of `schwarz.cpp`.
std::unique_ptr<SharedPreconditioner> schwarz_multigrid(const Processes& processes, const SharedMatrix& matrix,
                                                        const Numbering& numbering, const TexelPart& part,
                                                        const Texels& texels);

/// PETSc's, of what each process adds to the matrix. Every process must call it; the matrix must outlive it.
std::unique_ptr<SharedPreconditioner> bddc(const SharedMatrix& matrix, const Subdomain& subdomain);

}  // namespace mq::shared
