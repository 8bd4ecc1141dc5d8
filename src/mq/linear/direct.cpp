/// P·A·Pᵀ = L·Lᵀ (CHOLMOD) or L·D·Lᵀ (Eigen), P a fill-reducing order.
///
/// Both backends read one copy of the lower triangle with 64-bit indices. The factor of a few
/// million unknowns has more than 2³¹ entries, and one kind of index leaves one path to test.

#include "mq/linear/direct.h"

#include <cmath>
#include <functional>
#include <map>
#include <mutex>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "mq/base/apart.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/calling_thread.h"
#include "mq/linear/solver.h"

#ifdef MARQUETRY_WITH_CHOLMOD
#include <cholmod.h>
#endif

namespace mq {

namespace factors {

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

}  // namespace factors

using factors::Index, factors::Triangular;

namespace {

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
  virtual FactorisationCost analyse(const Triangular& A) = 0;
  /// Factors; returns the row where it stops, or -1.
  virtual Index factor(const Triangular& A) = 0;
  virtual Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const = 0;
  virtual Index factor_nonzeros() const = 0;
  virtual std::string name() const = 0;

  Triangular A;
  bool analysed = false, factored = false;
  FactorisationCost cost;
  double analyse_seconds = 0;
  double factor_seconds = 0;  ///< 0: none was made yet
};

namespace {

class EigenBackend final : public DirectSolver::Backend {
 public:
  FactorisationCost analyse(const Triangular& matrix) override {
    ldlt_.analyzePattern(copy(matrix));
    // Values and row numbers, and the permuted copy of the matrix beside them.
    constexpr Index bytes = sizeof(double) + sizeof(Index);
    return {.entries = ldlt_.entries(),
            .bytes = bytes * (ldlt_.entries() + 2 * Index(matrix.value.size())),
            .operations = ldlt_.operations()};
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

    /// Σ over columns of c², c the entries from the diagonal down: as CHOLMOD counts.
    double operations() const {
      return (m_nonZerosPerCol.cast<double>().array() + 1).square().sum();
    }
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

  FactorisationCost analyse(const Triangular& matrix) override {
    cholmod_sparse view = view_of(matrix);
    cholmod_l_free_factor(&factor_, &common_);
    factor_ = cholmod_l_analyze(&view, &common_);  // AMD, and METIS where AMD fills in much
    check("analysing");
    // Supernodes hold some zeros, and share their row numbers; the matrix is copied in their order.
    const Index own = factor_->is_super
                          ? Index(8 * (factor_->xsize + factor_->ssize + factor_->maxcsize))
                          : Index(16 * common_.lnz);
    return {.entries = Index(common_.lnz),
            .bytes = own + 16 * Index(matrix.value.size()),
            .operations = common_.fl};
  }

  Index factor(const Triangular& matrix) override {
    const OnCallingThread here;
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
    const OnCallingThread here;
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

constexpr double seconds_worth_a_thread = 0.1;
constexpr double seconds_per_entry = 2e-6;   // of the analysis
constexpr double operations_measured = 1e8;  // fewer take less than about a tenth of a second

/// The whole lower triangle: diagonal n, below it 1.
Triangular dense_triangle(Index n) {
  Triangular A;
  A.size = n;
  for (Index row = 0; row < n; ++row) {
    for (Index column = 0; column <= row; ++column) {
      A.column.push_back(column);
      A.value.push_back(column == row ? double(n) : 1);
    }
    A.begin.push_back(Index(A.column.size()));
  }
  return A;
}

/// On this machine as busy as it is now: for shorter than this its other work would decide.
constexpr double seconds_of_trials = 0.2;
/// What was found holds for so long: who factors many patterns does not try each time.
constexpr double seconds_of_pace = 60;

double tried_seconds_per_operation(Factorisation kind) {
  constexpr Index size = 400;
  const auto backend = make_backend(kind);
  const Triangular A = dense_triangle(size);
  const FactorisationCost cost = backend->analyse(A);
  const Stopwatch watch;
  for (int trials = 1;; ++trials) {
    backend->factor(A);
    if (const double seconds = watch.seconds(); seconds > seconds_of_trials)
      return seconds / (trials * cost.operations);
  }
}

double seconds_per_operation(Factorisation kind) {
  struct Pace {
    double seconds_per_operation;
    Stopwatch since;
  };
  static std::mutex mutex;
  static std::map<Factorisation, Pace> known;
  const std::lock_guard lock(mutex);
  const auto place = known.find(kind);
  if (place != known.end() && place->second.since.seconds() < seconds_of_pace)
    return place->second.seconds_per_operation;
  const double found = tried_seconds_per_operation(kind);
  known.insert_or_assign(kind, Pace{found, Stopwatch()});
  return found;
}

}  // namespace

std::vector<Factorisation> factorisations() {
#ifdef MARQUETRY_WITH_CHOLMOD
  return {Factorisation::cholmod, Factorisation::eigen};
#else
  return {Factorisation::eigen};
#endif
}

/// Where nobody waits till the work is done it keeps its backend, and this solver takes another.
void DirectSolver::run(const std::function<void()>& work, const Progress& progress,
                       double expected_seconds) {
  progress.check();
  if (expected_seconds < seconds_worth_a_thread) return work();
  try {
    run_apart(work, progress, expected_seconds);
  } catch (...) {
    backend_ = make_backend(kind_);
    throw;
  }
}

void DirectSolver::analyse(const Progress& progress, std::int64_t most_entries) {
  const Index rows = backend_->A.size, entries = Index(backend_->A.value.size());
  const auto work = [backend = backend_] {
    const Stopwatch watch;
    if (backend->A.size > 0) backend->cost = backend->analyse(backend->A);
    backend->analyse_seconds = watch.seconds();
  };
  run(work, progress, seconds_per_entry * double(entries));
  const FactorisationCost& cost = backend_->cost;
  if (cost.entries > most_entries)
    throw OutOfMemory(
        fmt::format("the factor of the matrix of {} rows would hold {} entries; at most "
                    "{} were asked for",
                    rows, cost.entries, most_entries));
  require_memory(cost.bytes, fmt::format("the factor of the matrix of {} rows", rows),
                 "an iterative solver (multigrid) needs far less");
  backend_->analysed = true;
  progress.at(1);
}

void DirectSolver::factor(const Progress& progress) {
  const auto stopped = std::make_shared<Index>(-1);
  const auto work = [backend = backend_, stopped] {
    const Stopwatch watch;
    if (backend->A.size > 0) *stopped = backend->factor(backend->A);
    backend->factor_seconds = watch.seconds();
  };
  run(work, progress, backend_->cost.operations > operations_measured ? expected_seconds() : 0);
  if (*stopped >= 0) throw_not_positive_definite(*stopped, backend_->A.size);
  backend_->factored = true;
  progress.at(1);
}

DirectSolver DirectSolver::analysed(const SparseMatrix& A, Factorisation kind,
                                    const Progress& progress, std::int64_t most_entries) {
  DirectSolver solver;
  solver.kind_ = kind;
  solver.backend_ = make_backend(kind);
  solver.backend_->A = lower_triangle(A);
  progress.check();
  solver.analyse(progress, most_entries);
  return solver;
}

DirectSolver::DirectSolver(const SparseMatrix& A, Factorisation kind, const Progress& progress,
                           std::int64_t most_entries)
    : DirectSolver(analysed(A, kind, progress.step("analysis", 0.3), most_entries)) {
  factor(progress.step("factorisation", 0.7));
}

DirectSolver::~DirectSolver() = default;
DirectSolver::DirectSolver(DirectSolver&&) noexcept = default;
DirectSolver& DirectSolver::operator=(DirectSolver&&) noexcept = default;

void DirectSolver::refactor(const SparseMatrix& A, const Progress& progress) {
  Triangular lower = lower_triangle(A);
  require(!backend_->analysed || lower.same_pattern(backend_->A),
          "a matrix factored again must have the pattern that was analysed");
  backend_->A = std::move(lower);
  backend_->factored = false;
  progress.check();
  if (!backend_->analysed)
    analyse(progress.step("analysis", 0.3), std::numeric_limits<std::int64_t>::max());
  factor(progress);
}

Signal DirectSolver::solve(const Signal& B, const Progress& progress) const {
  if (!backend_->factored)
    throw SolverError("the last factorisation failed; factor a matrix before solving with it");
  const Index size = backend_->A.size;
  require(B.rows() == size,
          fmt::format("a right-hand side of {} rows does not fit a matrix of {}", B.rows(), size));
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
  return backend_->factored && backend_->A.size > 0 ? backend_->factor_nonzeros() : 0;
}
std::int64_t DirectSolver::size() const { return backend_->A.size; }
const FactorisationCost& DirectSolver::cost() const { return backend_->cost; }

double DirectSolver::expected_seconds() const {
  if (backend_->factor_seconds > 0) return backend_->factor_seconds;
  return backend_->cost.operations * seconds_per_operation(kind_);
}

}  // namespace mq
