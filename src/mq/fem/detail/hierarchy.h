#pragma once
/// Everything between a matrix and a multigrid cycle, whatever the levels are made of.

#include <memory>

#include "mq/base/release.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/detail/surface_graph.h"
#include "mq/linear/mixed_cg.h"

namespace mq {

/// The levels of one matrix A, each with its values in single precision, and what of A that leaves.
/// All values are scaled so that the mean diagonal value of A is 1, which keeps single precision
/// away from its ends whatever the unit of the model is. Rows without a stencil and of hardly any
/// influence (a corner of a texel's footprint at a seam) get a unit of their own in which they are
/// not negligible: they would else be lost in the rounding of the others.
///
/// Levels are added from the finest on, then `finish` takes the coarsest; `texel_hierarchy` and
/// `vertex_multigrid_solver` say what they are.
class Hierarchy {
 public:
  /// For a matrix of so many rows and entries.
  Hierarchy(int rows, std::int64_t entries, const MultigridOptions& options);

  /// Adds a level with these rows (those of A at first), which are used up, and returns the matrix of the next.
  SparseMatrix add_level(StencilRows rows, StencilLayout layout, PatchSmoother::Kind kind,
                         std::unique_ptr<LevelTransfer> transfer, const Progress& progress);

  /// Adds levels of points on the surface, the first with `layout` and patches of `kind`, until a
  /// level has few rows; `points` are where the rows of `finest` lie. The matrix of the next level goes to
  /// `coarsest`, which may be `finest`: that is let go of as soon as it has been used. (Eigen's matrices
  /// cannot be moved, and copies of them take as long as all one thread has to do here.)
  void add_graph_levels(const SparseMatrix& finest, SurfacePoints points, StencilLayout layout,
                        PatchSmoother::Kind kind, const Progress& progress, SparseMatrix& coarsest);

  /// Takes the coarsest matrix.
  void finish(const SparseMatrix& coarsest);

  /// Takes the values of another matrix of the same pattern. Throws `InvalidInput` where it has another size.
  void set_values(const SparseMatrix& A, const Progress& progress = {});
  void set_values(StencilSystem&& A, const Progress& progress = {});

  /// Lets go of what only conjugate gradients in mixed precision need: no solver can be made of it
  /// any more.
  void keep_cycle_only() {
    low_ = {};
    components_ = {};
    release(coarsest_component_);
  }

  const MultigridOptions& options() const { return options_; }
  const Multigrid& multigrid() const { return multigrid_; }
  const StencilMatrix& high() const { return multigrid_.levels.front()->matrix; }
  const StencilMatrix& low() const { return low_; }
  const Components& components() const { return components_; }
  const Scaling& scaling() const { return scaling_; }
  std::int64_t entries() const { return entries_; }
  int rows() const { return rows_; }

  /// Memory of all levels.
  std::int64_t bytes() const;

 private:
  SparseMatrix take_values(StencilRows&& rows, std::size_t level, const Progress& progress);
  void take_coarsest_values(const SparseMatrix& coarsest);
  void label_components(const SparseMatrix& coarsest);
  void find_scaling(const StencilRows& A);
  void find_singular(const SparseMatrix& coarsest);
  void require_pattern(std::int64_t rows, std::int64_t entries) const;
  void take_all_values(StencilRows&& A, const Progress& progress);

  MultigridOptions options_;
  Multigrid multigrid_;
  StencilMatrix low_;
  Components components_;
  std::vector<int> coarsest_component_;  ///< per row of the coarsest level
  Scaling scaling_;
  double trace_ = 0;  ///< of the finest matrix
  int rows_ = 0;
  std::int64_t entries_ = 0;
};

/// Throws `InvalidInput` where A is not compressed or does not have one row for each of `nodes`.
void require_square(const SparseMatrix& A, std::int64_t nodes);

/// Of `rows` rows without any stencil.
StencilLayout layout_without_stencils(int rows);

/// Conjugate gradients around the cycle of a hierarchy, which took `setup_seconds` to make.
std::unique_ptr<LinearSolver> hierarchy_solver(Hierarchy hierarchy, double setup_seconds);

}  // namespace mq
