#pragma once
/// A symmetric sparse matrix in single precision whose rows are mostly 3 × 3 stencils.
///
/// Unknowns adjacent in a row of a picture are adjacent in memory, so that the neighbours of a run
/// of stencil rows are three runs themselves and no index is read. Of each symmetric pair one value
/// is kept: 5 floats per unknown. Rows that are no stencils (seams, chart borders, coarse levels of
/// irregular graphs) are kept as compressed rows beside them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mq/base/overwritten.h"
#include "mq/linear/kernels/stencil_kernels.h"
#include "mq/linear/stencil_rows.h"
#include "mq/linear/detail/scaling.h"

namespace mq {

/// Some of the rows of a matrix: what is done to them alone.
struct StencilPart {
  StencilTiles stencils;       ///< pieces of the layout's runs
  StencilTiles anisotropic;    ///< pieces of `StencilMatrix::anisotropic()`
  std::vector<int> irregular;  ///< positions among the layout's irregular rows
};

/// The ratio of the eigenvalues of Σ_j −a_kj d_j d_jᵀ, d_j from unknown k to j in texels: where A is
/// stiffness, that of the metric. Small where mass prevails, which relaxation likes.
inline double stencil_anisotropy(const Stencil& row) {
  const auto [nw, n, ne, w, centre, e, sw, s, se] = row;
  const double corners = nw + ne + sw + se;
  const double xx = -(w + e + corners), yy = -(n + s + corners), xy = -(se + nw - ne - sw);
  const double mean = (xx + yy) / 2, half = (xx - yy) / 2, radius = std::sqrt(half * half + xy * xy);
  return (mean + radius) / std::max(mean - radius, 0.02 * centre);
}

/// The order of relaxation; backward undoes forward step by step, which makes a cycle symmetric.
enum class Order { forward, backward };

/// Values for a layout. All vectors are rows × lanes (see `LaneVector`), lanes 1, 4 or 8 (`multiply`: 1 or 4).
class StencilMatrix {
 public:
  /// Texels of hardly any influence at seams may depend on one another but for less than single
  /// precision resolves; this keeps the matrix definite.
  static constexpr double raise = 1e-6;

  StencilMatrix() = default;

  /// A, which is used up, scaled and rounded to float; the diagonal of rows with a unit of
  /// their own raised by `raise` of itself. The layout must outlive the matrix. Throws
  /// `NotPositiveDefinite` where a diagonal value is not positive in a row that is not zero,
  /// `InvalidInput` where a value is not finite.
  StencilMatrix(StencilRows&& A, const StencilLayout& layout, const Scaling& scaling);

  /// The same matrix, `high`, with the row sums that `multiply` wants, and `low`, what rounding and raising changed:
  /// the two add up to the scaled A to 48 bits. `low` has no `listed_row`: its columns are those of `high`.
  struct Split;
  static Split split(StencilRows&& A, const StencilLayout& layout, const Scaling& scaling);

  const StencilLayout& layout() const { return *layout_; }
  int rows() const { return layout_ ? layout_->rows : 0; }

  /// Gauss–Seidel on the stencil rows: tile after tile `sweeps` times each, colour after colour,
  /// rows from the top, in a row first its even then its odd unknowns; then several times more, all
  /// tiles once each time, the runs where A is strongly anisotropic; or all of that reversed.
  void relax_stencils(int lanes, const float* b, float* x, int sweeps, Order order) const;

  /// The same for a part of the rows, whatever x holds in the others.
  void relax_stencils(const StencilPart& part, int lanes, const float* b, float* x, int sweeps,
                      Order order) const;

  /// r = b − A·x in every row.
  void residual(int lanes, const float* b, const float* x, float* r) const;

  /// r = b − A·x in some rows.
  void residual(const StencilPart& part, int lanes, const float* b, const float* x, float* r) const;

  /// What a step of conjugate gradients asks of A·x, per lane (of one lane in the first).
  struct Products : ProductSums {
    friend Products operator+(Products a, const Products& b) {
      for (int i = 0; i < 4; ++i) {
        a.with_product[i] += b.with_product[i];
        a.with_r[i] += b.with_r[i];
      }
      return a;
    }
  };

  /// y = A·x in every row, computed as (A·x)_k = m_k x_k + Σ_j a_kj (x_j − x_k) with the row sums m
  /// that `split` took before rounding: where A is mostly stiffness, smooth x lose nothing. In the same
  /// walk through memory the products of x with y and r.
  Products multiply(int lanes, const float* x, const float* r, float* y) const;

  /// The runs with strongly anisotropic rows, which are relaxed more often.
  const StencilTiles& anisotropic() const { return anisotropic_; }

  /// max over rows k of Σ_{j≠k} |a_kj| / a_kk: where it is below 1, every sweep of a relaxation leaves
  /// no more than that of the error.
  double dominance() const;

  /// The values of row layout().listed(position); the irregular ones come first.
  struct Row {
    int count;
    const int* columns;
    const float* values;
    float diagonal;
  };
  Row listed_row(int position) const {
    const std::int64_t begin = start_[position];
    return {int(start_[position + 1] - begin), columns_.data() + begin, values_.data() + begin,
            centre(layout_->listed(position))};
  }

  /// The values of such a row alone.
  const float* listed_values(int position) const { return values_.data() + start_[position]; }

  /// The five values of unknown k: A(k, k) and A(k, its right, lower left, lower and lower right
  /// neighbour). Meaningful in stencil rows and where stencil rows couple to others.
  float centre(int k) const { return *centres(k); }
  float east(int k) const { return *easts(k); }
  float south_west(int k) const { return *south_wests(k); }
  float south(int k) const { return *souths(k); }
  float south_east(int k) const { return *south_easts(k); }

  /// The same from unknown k on.
  const float* centres(int k) const { return &values5_[0][margin + k]; }
  const float* easts(int k) const { return &values5_[1][margin + k]; }
  const float* south_wests(int k) const { return &values5_[2][margin + k]; }
  const float* souths(int k) const { return &values5_[3][margin + k]; }
  const float* south_easts(int k) const { return &values5_[4][margin + k]; }

  using Streams = StencilStreams;

  /// The stencil rows, and the irregular and the clustered rows, for kernels.
  Streams stencils() const { return {centres(0), easts(0), south_wests(0), souths(0), south_easts(0)}; }
  ListedRows listed_rows() const;

  std::int64_t bytes() const;

 private:
  static constexpr int margin = 32;
  float* streams(int i) { return values5_[i].data() + margin; }
  void make_room(const SparseMatrix& listed, const StencilLayout& layout);
  void fill(StencilRows& A, const Scaling& scaling, StencilMatrix* low);
  void fill_listed(const SparseMatrix& listed, const Scaling& scaling, StencilMatrix* low);
  void keep_anisotropic_runs(const std::vector<char>& found);
  void relax_tiles(const StencilTiles& tiles, int lanes, const float* b, float* x, int sweeps,
                   Order order) const;
  void relax_with(const StencilTiles& tiles, const StencilTiles& anisotropic, int lanes,
                  const float* b, float* x, int sweeps, Order order) const;
  void residual_of_runs(const StencilTiles& tiles, int lanes, const float* b, const float* x,
                        float* r) const;

  const StencilLayout* layout_ = nullptr;
  OverwrittenVector<float> values5_[5];
  std::vector<float> row_sums_;
  StencilTiles anisotropic_;
  std::vector<std::int64_t> start_;
  std::vector<int> columns_;
  std::vector<float> values_;
};

struct StencilMatrix::Split {
  StencilMatrix high, low;
};

}  // namespace mq
