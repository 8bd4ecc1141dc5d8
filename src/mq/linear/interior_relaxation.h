#pragma once
/// Gauss–Seidel relaxation of 3 × 3 stencils as thesis 5.8.5 does it: in blocks, several sweeps
/// over each while it is in the cache.

#include <vector>

#include "mq/linear/kernels/relaxation_kernels.h"
#include "mq/linear/matrix.h"
#include "mq/linear/stencil_matrix.h"

namespace mq {

/// Stencil rows in blocks. A line is the blocks side by side in a strip of rows; a stencil couples
/// to its own line and the two next to it, so that all even lines may be relaxed at once, and then
/// all odd ones.
struct StencilBlocks {
  std::vector<StencilRun> segments;  ///< by line (even ones first), block, row, column
  std::vector<int> rows;             ///< row r has segments rows[r] … rows[r + 1] − 1
  std::vector<int> blocks;  ///< block b has rows blocks[b] … blocks[b + 1] − 1, from the top
  std::vector<int> lines;   ///< line l has blocks lines[l] … lines[l + 1] − 1
  int even_lines = 0;       ///< lines 0 … even_lines − 1 are the even ones
};

/// In which order the sweeps over a block walk it; the result is the same, bit for bit.
enum class SweepOrder {
  temporal,  ///< row r, then row r − 1 for the second time, r − 2 for the third, then row r + 1
  plain      ///< the whole block once, then again
};

/// Relaxes x in the rows of the blocks, towards A·x = b with all other unknowns held: even lines in
/// parallel, then odd ones; in a line block after block; on each block `sweeps` sweeps, each from
/// top to bottom and left to right. That cannot increase ‖x − A⁻¹b‖_A. The same bits for any number
/// of threads.
///
/// Vectors are rows × lanes, a row's lanes adjacent; lanes 1 or 4. Real is float or double: 10 of
/// them are held per texel, adjacent in the order in which they are used.
template <class Real>
class InteriorRelaxation {
 public:
  InteriorRelaxation() = default;
  explicit InteriorRelaxation(StencilBlocks blocks);

  /// Takes the values of A. Throws `NotPositiveDefinite` naming the row where a diagonal value is
  /// not positive.
  void set_values(const SparseMatrix& A);

  void relax(int lanes, const Real* b, Real* x, int sweeps,
             SweepOrder order = SweepOrder::temporal) const;

  /// r = b − A·x in the rows of the blocks.
  void residual(int lanes, const Real* b, const Real* x, Real* r) const;

  std::int64_t bytes() const;

 private:
  WholeStencils<Real> whole_stencils() const;

  StencilBlocks blocks_;
  std::vector<std::int64_t> starts_;  ///< per segment where its coefficients begin
  std::vector<Real> coefficients_;
};

extern template class InteriorRelaxation<float>;
extern template class InteriorRelaxation<double>;

}  // namespace mq
