/// P·A·Pᵀ = L·Lᵀ (CHOLMOD) or L·D·Lᵀ (Eigen), P a fill-reducing order.
///
/// Both backends read one copy of the lower triangle with 64-bit indices. The factor of a few
/// million unknowns has more than 2³¹ entries, and one kind of index leaves one path to test.

#include "mq/linear/direct.h"

#include <cmath>
#include <mutex>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/solver.h"

#ifdef MARQUETRY_WITH_CHOLMOD
#include <cholmod.h>
#endif

namespace mq {

namespace {

using Index = std::int64_t;

/// The lower triangle by rows, which is the upper triangle by columns.
struct Triangular {
  Index size = 0;
  std::vector<Index> begin{0};  ///< per row where its entries begin
  std::vector<Index> column;
  std::vector<double> value;

  bool same_pattern(const Triangular& other) const {
    return begin == other.begin && column == other.column;
  }
};

Triangular lower_triangle(const SparseMatrix& A) {
  require(A.rows() == A.cols(), fmt::format("a direct solver factors square matrices; this one has "
                                            "{} rows and {} columns", A.rows(), A.cols()));
  Triangular lower;
  lower.size = A.rows();
  lower.begin.reserve(A.rows() + 1);
  lower.column.reserve((A.nonZeros() + A.rows()) / 2);
  lower.value.reserve((A.nonZeros() + A.rows()) / 2);
  for (int row = 0; row < A.rows(); ++row) {
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
      if (!std::isfinite(entry.value()))
        throw InvalidInput(fmt::format("the matrix to factor holds {} in row {}, column {}; its "
                                       "entries must be finite", entry.value(), row, entry.col()));
      if (entry.col() > row) continue;
      lower.column.push_back(entry.col());
      lower.value.push_back(entry.value());
    }
    lower.begin.push_back(Index(lower.column.size()));
  }
  return lower;
}

[[noreturn]] void throw_not_positive_definite(Index row, Index size) {
  throw NotPositiveDefinite(fmt::format(
      "the matrix is not positive definite: its factorisation stops at row {} of {}. A row of "
      "zeros, a part of the domain without area or a negative weight does this", row, size));
}

}  // namespace

class DirectSolver::Backend {
 public:
  virtual ~Backend() = default;
  /// Returns how many entries the factor will have.
  virtual Index analyse(const Triangular& A) = 0;
  /// Factors; returns the row where it stops, or -1.
  virtual Index factor(const Triangular& A) = 0;
  virtual Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const = 0;
  virtual Index factor_nonzeros() const = 0;
  virtual std::string name() const = 0;

  Triangular A;
  bool factored = false;
  double analyse_seconds = 0;
  double factor_seconds = 0;
};

namespace {

class EigenBackend final : public DirectSolver::Backend {
 public:
  Index analyse(const Triangular& matrix) override {
    ldlt_.analyzePattern(copy(matrix));
    return ldlt_.entries();
  }

  Index factor(const Triangular& matrix) override {
    ldlt_.factorize(copy(matrix));
    const auto& D = ldlt_.vectorD();
    for (Index k = 0; k < D.size(); ++k)
      if (!(D[k] > 0)) return ldlt_.permutationPinv().indices()[k];
    return -1;
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const override { return ldlt_.solve(B); }

  Index factor_nonzeros() const override { return ldlt_.entries(); }

  std::string name() const override { return "eigen"; }

 private:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;

  static Matrix copy(const Triangular& m) {
    return Eigen::Map<const Matrix>(m.size, m.size, Index(m.value.size()), m.begin.data(),
                                    m.column.data(), m.value.data());
  }

  struct Ldlt : Eigen::SimplicialLDLT<Matrix, Eigen::Upper, Eigen::AMDOrdering<Index>> {
    Index entries() const { return m_matrix.nonZeros() + m_matrix.cols(); }
  };
  Ldlt ldlt_;
};

#ifdef MARQUETRY_WITH_CHOLMOD

class CholmodBackend final : public DirectSolver::Backend {
 public:
  CholmodBackend() {
    static_assert(sizeof(SuiteSparse_long) == sizeof(Index));
    cholmod_l_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_AUTO;
    common_.final_ll = true;  // L·Lᵀ, simplicial too: it stops at a pivot that is not positive
  }
  ~CholmodBackend() override {
    cholmod_l_free_factor(&factor_, &common_);
    cholmod_l_finish(&common_);
  }
  CholmodBackend(const CholmodBackend&) = delete;
  CholmodBackend& operator=(const CholmodBackend&) = delete;

  Index analyse(const Triangular& matrix) override {
    cholmod_sparse view = view_of(matrix);
    cholmod_l_free_factor(&factor_, &common_);
    factor_ = cholmod_l_analyze(&view, &common_);  // AMD, and METIS where AMD fills in much
    check("analysing");
    return Index(common_.lnz);
  }

  Index factor(const Triangular& matrix) override {
    cholmod_sparse view = view_of(matrix);
    cholmod_l_factorize(&view, factor_, &common_);
    if (common_.status == CHOLMOD_NOT_POSDEF || factor_->minor < factor_->n)
      return static_cast<const Index*>(factor_->Perm)[factor_->minor];
    check("factoring");
    return -1;
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const override {
    cholmod_dense view = {};
    view.nrow = view.d = std::size_t(B.rows());
    view.ncol = std::size_t(B.cols());
    view.nzmax = std::size_t(B.size());
    view.x = const_cast<double*>(B.data());
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    const std::lock_guard lock(mutex_);  // CHOLMOD keeps its workspace in common_
    cholmod_dense* solution = cholmod_l_solve(CHOLMOD_A, factor_, &view, &common_);
    check("solving with");
    Eigen::MatrixXd X =
        Eigen::Map<const Eigen::MatrixXd>(static_cast<double*>(solution->x), B.rows(), B.cols());
    cholmod_l_free_dense(&solution, &common_);
    return X;
  }

  Index factor_nonzeros() const override {
    return factor_->is_super ? Index(factor_->xsize) : Index(factor_->nzmax);
  }

  std::string name() const override { return "cholmod"; }

 private:
  static cholmod_sparse view_of(const Triangular& m) {
    cholmod_sparse view = {};
    view.nrow = view.ncol = std::size_t(m.size);
    view.nzmax = m.value.size();
    view.p = const_cast<Index*>(m.begin.data());
    view.i = const_cast<Index*>(m.column.data());
    view.x = const_cast<double*>(m.value.data());
    view.stype = 1;  // the upper triangle by columns
    view.itype = CHOLMOD_LONG;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = true;
    return view;
  }

  void check(const char* doing) const {
    if (common_.status >= 0) return;
    const char* found = common_.status == CHOLMOD_OUT_OF_MEMORY ? "memory ran out"
                        : common_.status == CHOLMOD_TOO_LARGE   ? "the problem is too large"
                                                                : "CHOLMOD failed";
    throw SolverError(fmt::format("{} the matrix of {} rows: {} (status {}); an iterative solver "
                                  "needs far less memory", doing, A.size, found, common_.status));
  }

  mutable cholmod_common common_;
  mutable std::mutex mutex_;
  cholmod_factor* factor_ = nullptr;
};

#endif

std::unique_ptr<DirectSolver::Backend> make_backend(Factorisation kind) {
  if (kind == Factorisation::automatic) kind = factorisations().front();
  if (kind == Factorisation::eigen) return std::make_unique<EigenBackend>();
#ifdef MARQUETRY_WITH_CHOLMOD
  return std::make_unique<CholmodBackend>();
#else
  throw Unsupported("this program was built without CHOLMOD (MARQUETRY_CHOLMOD=OFF, or it was not "
                    "found); ask for the factorisation \"eigen\" or \"automatic\"");
#endif
}

}  // namespace

std::vector<Factorisation> factorisations() {
#ifdef MARQUETRY_WITH_CHOLMOD
  return {Factorisation::cholmod, Factorisation::eigen};
#else
  return {Factorisation::eigen};
#endif
}

DirectSolver::DirectSolver(const SparseMatrix& A, Factorisation kind, const Progress& progress,
                           std::int64_t most_entries)
    : backend_(make_backend(kind)) {
  backend_->A = lower_triangle(A);
  progress.check();
  const Progress step = progress.step("analysis", 0.3);
  const Stopwatch watch;
  const Index entries = A.rows() > 0 ? backend_->analyse(backend_->A) : 0;
  if (entries > most_entries)
    throw OutOfMemory(fmt::format("the factor of the matrix of {} rows would hold {} entries; at most "
                                  "{} were asked for", A.rows(), entries, most_entries));
  constexpr Index bytes_per_entry = 9;  // the value, and indices that supernodes share
  require_memory(bytes_per_entry * entries,
                 fmt::format("the factor of the matrix of {} rows", A.rows()),
                 "an iterative solver (multigrid) needs far less");
  backend_->analyse_seconds = watch.seconds();
  step.at(1);
  refactor(A, progress.step("factorisation", 0.7));
}

DirectSolver::~DirectSolver() = default;
DirectSolver::DirectSolver(DirectSolver&&) noexcept = default;
DirectSolver& DirectSolver::operator=(DirectSolver&&) noexcept = default;

void DirectSolver::refactor(const SparseMatrix& A, const Progress& progress) {
  Triangular lower = lower_triangle(A);
  require(lower.same_pattern(backend_->A),
          "a matrix factored again must have the pattern that was analysed");
  backend_->A = std::move(lower);
  backend_->factored = false;
  progress.check();
  const Stopwatch watch;
  const Index stopped = A.rows() > 0 ? backend_->factor(backend_->A) : -1;
  backend_->factor_seconds = watch.seconds();
  if (stopped >= 0) throw_not_positive_definite(stopped, A.rows());
  backend_->factored = true;
  progress.at(1);
}

Signal DirectSolver::solve(const Signal& B, const Progress& progress) const {
  const Index size = backend_->A.size;
  require(B.rows() == size, fmt::format("a right-hand side of {} rows does not fit a matrix of {}",
                                        B.rows(), size));
  if (!backend_->factored)
    throw SolverError("the last factorisation failed; factor a matrix before solving with it");
  progress.check();
  if (B.size() == 0) return B;
  Signal X = backend_->solve(B);
  progress.at(1);
  return X;
}

std::string DirectSolver::name() const { return backend_->name(); }
double DirectSolver::analyse_seconds() const { return backend_->analyse_seconds; }
double DirectSolver::factor_seconds() const { return backend_->factor_seconds; }
std::int64_t DirectSolver::factor_nonzeros() const {
  return backend_->A.size > 0 ? backend_->factor_nonzeros() : 0;
}

}  // namespace mq
