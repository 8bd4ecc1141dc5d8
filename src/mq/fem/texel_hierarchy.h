#pragma once
/// The levels of a texel system: everything between a matrix and a multigrid cycle.

#include "mq/fem/multigrid_solver.h"
#include "mq/fem/surface_graph.h"
#include "mq/linear/mixed_cg.h"

namespace mq {

class TexelHierarchy {
 public:
  /// Builds the levels by the pattern of A and the places of the texels, then takes A's values.
  TexelHierarchy(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options,
                 const Progress& progress = {});

  /// Takes the values of another matrix of the same pattern.
  void set_values(const SparseMatrix& A, const Progress& progress = {});

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
  void build(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options,
             const Progress& progress);
  void take_values(const SparseMatrix& A, int level);
  void take_finest_values(const SparseMatrix& A);
  void take_coarsest_values(SparseMatrix A);
  void label_components(const SparseMatrix& coarsest);
  void find_scaling(const SparseMatrix& A);
  void find_singular(const SparseMatrix& A);

  Multigrid multigrid_;
  StencilMatrix low_;
  Components components_;
  std::vector<int> coarsest_component_;  ///< per row of the coarsest level
  Scaling scaling_;
  int rows_ = 0;
  std::int64_t entries_ = 0;
};

}  // namespace mq
