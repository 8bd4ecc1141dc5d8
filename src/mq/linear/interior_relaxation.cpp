/// In row k, with the neighbours numbered as one reads,
///
///     x_4 ← (b − Σ_{j≠4} a_j x_j) / a_4.
///
/// Temporal blocking (thesis 5.8.5): a row needs the row above after the same sweep, and the row below
/// after the sweep before. Walking r + s = 0, 1, 2, ... over rows r and sweeps s, and at each the sweeps
/// in turn, keeps to that: every number is what plain sweeps make of it, while a row is used for all
/// sweeps within a few rows.

#include "mq/linear/interior_relaxation.h"

#include <fmt/format.h>

#include "mq/base/parallel.h"
#include "mq/linear/kernels/relaxation_kernels.h"
#include "mq/linear/solver.h"

namespace mq {

template <class Real>
InteriorRelaxation<Real>::InteriorRelaxation(StencilBlocks blocks) : blocks_(std::move(blocks)) {
  starts_.reserve(blocks_.segments.size() + 1);
  starts_.push_back(0);
  for (const StencilRun& s : blocks_.segments)
    starts_.push_back(starts_.back() + std::int64_t(WholeStencils<Real>::stride) * s.count);
  coefficients_.resize(starts_.back());
}

template <class Real>
void InteriorRelaxation<Real>::set_values(const SparseMatrix& A) {
  parallel_for(
      std::int64_t(blocks_.segments.size()),
      [&](std::int64_t i) {
        const StencilRun& s = blocks_.segments[i];
        Real* a = coefficients_.data() + starts_[i];
        for (int k = s.first; k < s.first + s.count; ++k, a += WholeStencils<Real>::stride) {
          const double* row = A.valuePtr() + A.outerIndexPtr()[k];
          if (!(row[4] > 0))
            throw NotPositiveDefinite(fmt::format(
                "the matrix is not positive definite: its diagonal is {} in row {}", row[4], k));
          for (int j = 0; j < 9; ++j) a[j] = Real(row[j]);
          a[9] = Real(1 / row[4]);
        }
      },
      64);
}

template <class Real>
WholeStencils<Real> InteriorRelaxation<Real>::whole_stencils() const {
  return {blocks_.segments.data(), blocks_.rows.data(), starts_.data(), coefficients_.data()};
}

template <class Real>
void InteriorRelaxation<Real>::relax(int lanes, const Real* b, Real* x, int sweeps,
                                     SweepOrder order) const {
  const WholeStencils<Real> A = whole_stencils();
  const auto relax_rows = order == SweepOrder::temporal ? relaxation_kernels<Real>().relax
                                                        : relaxation_kernels<Real>().relax_plainly;
  const int line_count = int(blocks_.lines.size()) - 1;
  const auto relax_lines = [&](int begin, int end) {
    parallel_for(
        end - begin,
        [&](std::int64_t i) {
          const int line = begin + int(i);
          for (int block = blocks_.lines[line]; block < blocks_.lines[line + 1]; ++block)
            relax_rows(lanes, A, blocks_.blocks[block], blocks_.blocks[block + 1], b, x, sweeps);
        },
        1);
  };
  relax_lines(0, blocks_.even_lines);
  relax_lines(blocks_.even_lines, line_count);
}

template <class Real>
void InteriorRelaxation<Real>::residual(int lanes, const Real* b, const Real* x, Real* r) const {
  const WholeStencils<Real> A = whole_stencils();
  parallel_blocks(std::int64_t(blocks_.segments.size()), 64,
                  [&](std::int64_t begin, std::int64_t end) {
                    relaxation_kernels<Real>().residual(lanes, A, begin, end, b, x, r);
                  });
}

template <class Real>
std::int64_t InteriorRelaxation<Real>::bytes() const {
  return std::int64_t(coefficients_.size() * sizeof(Real) + starts_.size() * sizeof(starts_[0]) +
                      blocks_.segments.size() * sizeof(StencilRun));
}

template class InteriorRelaxation<float>;
template class InteriorRelaxation<double>;

}  // namespace mq
