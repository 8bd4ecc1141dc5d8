#pragma once
/// A symmetric sparse matrix in double precision whose rows are mostly 3 × 3 stencils: what a
/// `StencilMatrix` and the next coarser level are made of.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "mq/base/overwritten.h"
#include "mq/base/release.h"
#include "mq/linear/matrix.h"
#include "mq/linear/stencil_layout.h"

namespace mq {

/// The nine values of a stencil row, row by row of the picture.
using Stencil = std::array<double, 9>;

/// The value in the middle and of four of the eight others, in this order in every row: the rest are those of the
/// rows around, as the matrix is symmetric.
enum class Coupling { centre, right, lower_left, lower, lower_right };

/// Stencil rows keep five values each and no index, the others lie in compressed rows: half the memory of a matrix
/// all of whose rows are compressed. Which row is a stencil its layout says, which all functions must be given as it was.
class StencilRows {
 public:
  /// Of a matrix in compressed rows, which is kept as `listed()` and must outlive this.
  StencilRows(const SparseMatrix& A, const StencilLayout& layout);

  /// Of stencils with the value 0, to be filled by `at`, and of the other rows: `irregular` has no entries in those
  /// that are stencils.
  StencilRows(std::unique_ptr<SparseMatrix> irregular, const StencilLayout& layout);

  int rows() const { return int(listed_->rows()); }

  /// The entries of the whole matrix.
  std::int64_t entries() const { return entries_; }

  /// A matrix that has the irregular rows, and the clustered ones where `list_clustered` was called.
  const SparseMatrix& listed() const { return *listed_; }

  /// Whether `listed()` has all rows.
  bool complete() const { return !own_; }

  /// Whether any row is a stencil, so that `at` may be asked.
  bool has_stencils() const { return has_stencils_; }

  /// Gives the clustered rows of the layout entries in `listed()` too, where they have none.
  void list_clustered(const StencilLayout& layout);

  /// The value of a row and one of its neighbours; of meaning where one of the two is a stencil.
  double& at(int row, Coupling coupling) { return values_[std::size_t(coupling)][std::size_t(margin + row)]; }
  double at(int row, Coupling coupling) const {
    return values_[std::size_t(coupling)][std::size_t(margin + row)];
  }

  /// The values of row first + i of a run.
  Stencil stencil(const StencilRun& run, int i) const {
    const int up = run.up + i, k = run.first + i;
    return {at(up - 1, Coupling::lower_right), at(up, Coupling::lower), at(up + 1, Coupling::lower_left),
            at(k - 1, Coupling::right),        at(k, Coupling::centre), at(k, Coupling::right),
            at(k, Coupling::lower_left),       at(k, Coupling::lower),  at(k, Coupling::lower_right)};
  }

  /// Lets go of the values of one coupling in all rows.
  void drop(Coupling coupling) { release(values_[std::size_t(coupling)]); }

  /// All rows compressed.
  SparseMatrix matrix(const StencilLayout& layout) const;

 private:
  static constexpr int margin = 32;
  void make_room(const StencilLayout& layout);

  std::unique_ptr<SparseMatrix> own_;
  const SparseMatrix* listed_;
  OverwrittenVector<double> values_[5];
  std::int64_t entries_ = 0;
  bool has_stencils_ = false;
};

/// A matrix and which of its rows are stencils.
struct StencilSystem {
  StencilLayout layout;
  StencilRows rows;

  SparseMatrix matrix() const { return rows.matrix(layout); }
};

}  // namespace mq
