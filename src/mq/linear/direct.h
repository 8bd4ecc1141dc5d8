#pragma once
/// Direct factorisation of symmetric positive definite matrices, behind one small interface.

#include <functional>
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

/// What a factorisation will take, known once its pattern is analysed.
struct FactorisationCost {
  std::int64_t entries = 0;  ///< of the factor
  std::int64_t bytes = 0;    ///< of it and of what is needed beside it while it is made
  double operations = 0;     ///< additions and multiplications
};

/// A = L·Lᵀ of a symmetric positive definite matrix, analysed and factored once, solved many times.
///
/// Neither step can be interrupted, so large ones run apart (`run_apart`): asked to stop, they
/// throw `Cancelled` within 0.1 s, and a thread of their own goes on until it is done.
class DirectSolver {
 public:
  /// Analyses (fill-reducing order) and factors `A`, which is stored whole; only its lower triangle
  /// is read. Throws `NotPositiveDefinite` naming the row, `InvalidInput` when A is not square or
  /// holds a NaN, `OutOfMemory` when the factor will not fit or would hold more than
  /// `most_entries`, and `Cancelled`.
  explicit DirectSolver(const SparseMatrix& A, Factorisation kind = Factorisation::automatic,
                        const Progress& progress = {},
                        std::int64_t most_entries = std::numeric_limits<std::int64_t>::max());

  /// Only analyses `A`: `refactor` comes before the first `solve`. Throws as above.
  static DirectSolver analysed(
      const SparseMatrix& A, Factorisation kind = Factorisation::automatic,
      const Progress& progress = {},
      std::int64_t most_entries = std::numeric_limits<std::int64_t>::max());

  ~DirectSolver();
  DirectSolver(DirectSolver&&) noexcept;
  DirectSolver& operator=(DirectSolver&&) noexcept;

  /// Factors another matrix of the same pattern, keeping the analysis. Throws as above, and
  /// `InvalidInput` when the pattern is another; nothing can be solved then until a factorisation
  /// succeeds. After `Cancelled` the next one analyses its matrix anew.
  void refactor(const SparseMatrix& A, const Progress& progress = {});

  /// X with A·X = B, all columns of B at once.
  Signal solve(const Signal& B, const Progress& progress = {}) const;

  std::string name() const;        ///< "cholmod" or "eigen"
  double analyse_seconds() const;  ///< time of the symbolic step
  double factor_seconds() const;   ///< time of the last numeric step
  std::int64_t factor_nonzeros() const;
  std::int64_t size() const;  ///< rows of A
  const FactorisationCost& cost() const;

  /// How long the next factorisation will take: as long as the last one of this pattern, or else as
  /// its operations take at the pace of a small dense matrix, factored for that once a minute. Within
  /// about a factor of two.
  double expected_seconds() const;

  /// What a solver behind this interface does; see direct.cpp for the two that exist.
  class Backend;

 private:
  DirectSolver() = default;
  void run(const std::function<void()>& work, const Progress& progress, double expected_seconds);
  void analyse(const Progress& progress, std::int64_t most_entries);
  void factor(const Progress& progress);

  Factorisation kind_ = Factorisation::automatic;
  std::shared_ptr<Backend> backend_;  ///< shared with a thread that was left behind
};

}  // namespace mq
