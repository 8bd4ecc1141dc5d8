#pragma once
/// The smallest eigenpairs of a sparse symmetric pencil.

#include "mq/base/progress.h"
#include "mq/linear/direct.h"
#include "mq/linear/matrix.h"

namespace mq {

/// Eigenvalues in ascending order, and per column of `vectors` the eigenvector, of norm 1 in B and
/// with its largest component positive.
struct EigenPairs {
  Vector values;
  Eigen::MatrixXd vectors;
};

struct EigenOptions {
  enum class Pencil {
    semidefinite,  ///< A is, and B is definite
    any            ///< A may have negative eigenvalues, and B vectors without mass
  } pencil = Pencil::semidefinite;
  int count = 10;            ///< pairs wanted; at most the number of rows
  int block = 0;             ///< vectors advanced together; 0: count, at least 4 and at most 24
  double tolerance = 1e-10;  ///< of the residual, relative to the eigenvalue of (A − σB)⁻¹B
  Factorisation factorisation = Factorisation::automatic;
};

/// A·x = λ·B·x for symmetric semidefinite A and symmetric positive definite B of equal size: the
/// `count` smallest λ.
///
/// Block Lanczos on (A − σB)⁻¹B with σ = −tr A / (n·tr B): eigenvalues of a
/// multiplicity up to the block's size, null spaces among them, are found whole, which a single
/// starting vector cannot promise. Costs one factorisation and about 3·count solves, storage for as
/// many vectors. Of `Pencil::any` σ is lowered fourfold until A − σB is definite, which proves that there is no λ
/// below, and brought near to the lowest by halving the last step (up to 27 factorisations in all); vectors without mass,
/// whose λ is infinite, are left out. Matrices of up to 800 rows are decomposed as dense ones. Deterministic. Throws
/// `InvalidInput` on sizes that do not fit, `NotPositiveDefinite`, and `SolverError` where
/// 20·count + 400 vectors did not suffice, or fewer λ than `count` are finite.
EigenPairs smallest_eigenpairs(const SparseMatrix& A, const SparseMatrix& B,
                               const EigenOptions& options = {}, const Progress& progress = {});

}  // namespace mq
