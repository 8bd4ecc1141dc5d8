#pragma once
/// The levels of the reference solver and its V-cycle (thesis 5.8.1 and 5.8.2).

#include <memory>
#include <optional>
#include <vector>

#include "mq/baseline/reference_solver.h"
#include "mq/linear/boundary_rows.h"
#include "mq/linear/direct.h"
#include "mq/linear/interior_relaxation.h"
#include "mq/linear/interpolation.h"

namespace mq {

/// The stencil rows of a level in blocks of 128 × `block_height` texels.
StencilBlocks make_blocks(const StencilLayout& layout, const Texels& texels, int block_height);

/// The unknowns of constants that a semidefinite matrix does not determine.
struct NullSpace {
  std::vector<int> component;  ///< per unknown
  std::vector<char> singular;  ///< per component: A·1 = 0 there

  explicit NullSpace(const SparseMatrix& A);
  NullSpace() = default;
  bool empty() const;
};

/// x ← one V-cycle towards A·x = b. Vectors are rows × lanes (1 or 4), a row's lanes adjacent.
template <class Real>
class ReferenceCycle {
 public:
  ReferenceCycle(const SparseMatrix& A, const Texels& texels, const ReferenceOptions& options,
                 const Progress& progress = {});

  /// Takes the values of another matrix of the same pattern.
  void set_values(const SparseMatrix& A, const Progress& progress = {});

  /// The vectors of one cycle, made once and used by many.
  class Workspace {
   public:
    Workspace(const ReferenceCycle& cycle, int lanes, int channels);

   private:
    friend class ReferenceCycle;
    struct Vectors {
      std::vector<Real> b, x, r;
    };
    std::vector<Vectors> levels_;  ///< entry 0 has r only; the last is the coarsest
    int lanes_, channels_;
  };

  void cycle(const Real* b, Real* x, Workspace& workspace) const;

  /// r = b − A·x in every row.
  void residual(int lanes, const Real* b, const Real* x, Real* r) const;

  struct Level {
    InteriorRelaxation<Real> interior;
    BoundaryRows<Real> boundary;
    std::vector<char> boundary_pins;
    std::optional<DirectSolver> boundary_solver;  ///< none where there is no boundary
    std::unique_ptr<LevelTransfer> transfer;
    Interpolation<Real> interpolation;
  };
  /// R.4 and R.5 of a level, and C.1, for lanes and channels of the workspace: steps of `cycle`.
  void solve_boundary(const Level& level, const Real* b, Real* x, const Workspace& workspace) const;
  void solve_coarsest(const Real* b, Real* x, const Workspace& workspace) const;

  /// All but the coarsest, finest first.
  const std::vector<Level>& levels() const { return levels_; }
  int rows() const { return rows_; }
  int coarsest_rows() const { return coarsest_rows_; }
  const NullSpace& null_space() const { return null_space_; }

  /// Memory of all levels.
  std::int64_t bytes() const;

 private:
  void take_values(const SparseMatrix& A, Level& level, double raised);
  void take_coarsest_values(const SparseMatrix& A);
  void descend(std::size_t level, const Real* b, Real* x, Workspace& workspace) const;

  ReferenceOptions options_;
  int rows_ = 0, coarsest_rows_ = 0;
  std::int64_t entries_ = 0;
  NullSpace null_space_;
  std::vector<Level> levels_;
  std::vector<char> coarsest_pins_;
  std::optional<DirectSolver> coarsest_solver_;
};

extern template class ReferenceCycle<float>;
extern template class ReferenceCycle<double>;

}  // namespace mq
