#pragma once
/// Direct factorisation of symmetric positive definite matrices, behind one small interface.

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/matrix.h"

namespace mq {

enum class Factorisation {
  automatic,  ///< CHOLMOD where this build has it, else Eigen
  cholmod,    ///< supernodal Cholesky; throws `Unsupported` where this build lacks it
  eigen       ///< Eigen's simplicial L·D·Lᵀ
};

/// The kinds this build offers, `automatic` not among them.
std::vector<Factorisation> factorisations();

/// A = L·Lᵀ of a symmetric positive definite matrix, analysed and factored once, solved many times.
class DirectSolver {
 public:
  /// Analyses (fill-reducing order) and factors `A`, which is stored whole; only its lower triangle
  /// is read. Throws `NotPositiveDefinite` naming the row, `InvalidInput` when A is not square or
  /// holds a NaN, `OutOfMemory` when the factor will not fit or would hold more than `most_entries`,
  /// and `Cancelled` between the two steps.
  explicit DirectSolver(const SparseMatrix& A, Factorisation kind = Factorisation::automatic,
                        const Progress& progress = {},
                        std::int64_t most_entries = std::numeric_limits<std::int64_t>::max());
  ~DirectSolver();
  DirectSolver(DirectSolver&&) noexcept;
  DirectSolver& operator=(DirectSolver&&) noexcept;

  /// Factors another matrix of the same pattern, keeping the analysis. Throws as above, and
  /// `InvalidInput` when the pattern is another; nothing can be solved then until a factorisation
  /// succeeds.
  void refactor(const SparseMatrix& A, const Progress& progress = {});

  /// X with A·X = B, all columns of B at once.
  Signal solve(const Signal& B, const Progress& progress = {}) const;

  std::string name() const;        ///< "cholmod" or "eigen"
  double analyse_seconds() const;  ///< time of the symbolic step
  double factor_seconds() const;   ///< time of the last numeric step
  std::int64_t factor_nonzeros() const;

  /// What a solver behind this interface does; see direct.cpp for the two that exist.
  class Backend;

 private:
  std::unique_ptr<Backend> backend_;
};

}  // namespace mq
