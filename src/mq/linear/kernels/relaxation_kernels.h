#pragma once
/// The sweeps of `InteriorRelaxation` and the rows of `BoundaryRows`, in either precision and in the
/// forms of base/kernel_forms.h.

#include "mq/linear/kernels/stencil_kernels.h"

namespace mq {

/// Stencil rows with 10 values each: the nine of the row as one reads them, then 1/a_4.
template <class Real>
struct WholeStencils {
  static constexpr int stride = 10;

  const StencilRun* segments;
  const int* rows;             ///< row r has segments rows[r] … rows[r + 1] − 1
  const std::int64_t* starts;  ///< per segment where its values begin
  const Real* values;
};

/// A value of a sparse row.
template <class Real>
struct RowEntry {
  int column;
  Real value;
};

/// Sparse rows p = begin … end − 1: rows[p] of the matrix, with entries starts[p] … ends[p] − 1.
template <class Real>
struct SparseRows {
  const int* rows;
  const std::int64_t *starts, *ends;
  const RowEntry<Real>* entries;
  std::int64_t begin, end;
};

template <class Real>
struct RelaxationKernels {
  /// Sweeps over rows begin … end − 1: row r, then row r − 1 for the second time, r − 2 for the third,
  /// then row r + 1; or plainly, all rows once and then again.
  void (*relax)(int lanes, const WholeStencils<Real>& A, int begin, int end, const Real* b, Real* x,
                int sweeps);
  void (*relax_plainly)(int lanes, const WholeStencils<Real>& A, int begin, int end, const Real* b,
                        Real* x, int sweeps);
  /// r = b − A·x in segments begin … end − 1.
  void (*residual)(int lanes, const WholeStencils<Real>& A, std::int64_t begin, std::int64_t end,
                   const Real* b, const Real* x, Real* r);
  /// b − A·x in sparse rows: of row p to row to[p] of r or, where there is no `to`, to row p.
  void (*residual_of_sparse)(int lanes, const SparseRows<Real>& A, const Real* b, const Real* x,
                             const int* to, Real* r);
};

MARQUETRY_KERNELS(RelaxationKernels<float>, float_relaxation_kernels)
MARQUETRY_KERNELS(RelaxationKernels<double>, double_relaxation_kernels)

template <class Real>
const RelaxationKernels<Real>& relaxation_kernels() {
  if constexpr (sizeof(Real) == sizeof(float))
    return float_relaxation_kernels();
  else
    return double_relaxation_kernels();
}

}  // namespace mq
