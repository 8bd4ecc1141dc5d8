#pragma once
/// The texels of a process with a rim of others' around them, as far as the matrix couples in some steps.

#include <optional>
#include <vector>

#include "mq/fem/texels.h"
#include "halo.h"
#include "shared_matrix.h"

namespace mq::shared {

class Rim {
 public:
  /// `steps` couplings wide. `texels` are those of the part's space. Every process must call it, and all that it has.
  Rim(const Processes& processes, const SharedMatrix& matrix, const Numbering& numbering, const TexelPart& part,
      const Texels& texels, int steps);

  /// The matrix among the texels, and where these lie, in their order (texture, row, column). Those at the outer end of
  /// the rim are no stencils.
  const SparseMatrix& matrix() const { return matrix_; }
  const Texels& texels() const { return texels_; }
  /// Lets go of both.
  void let_go_of_matrix() {
    matrix_ = SparseMatrix();
    texels_ = {};
  }

  /// Per texel its number among all.
  const std::vector<std::int64_t>& numbers() const { return numbers_; }

  int size() const { return int(numbers_.size()); }

  /// Per texel how much of it is this process's: over all processes it sums to 1, and it falls to nearly 0 towards the
  /// outer end of the rim.
  const std::vector<double>& share() const { return share_; }

  /// Values of the own rows, in their order, and of the rim, fetched from others.
  Signal with_rim(const Signal& own) const;

  /// The own rows of values that have the rim's too.
  Signal own_rows(const Signal& values) const;

  /// The sums of what all processes have for each texel, of the own rows.
  Signal summed(const Signal& values) const;

 private:
  struct Found;
  Found find(const SharedMatrix& matrix, const Numbering& numbering, const TexelPart& part, const Texels& texels,
             int steps) const;
  std::vector<char> take(const Found& found, const SharedMatrix& matrix, const Numbering& numbering,
                         const TexelPart& part, const Texels& texels);
  void find_shares(const std::vector<char>& cut, int steps);

  const Processes& processes_;
  std::optional<Halo> halo_;
  SparseMatrix matrix_;
  Texels texels_;
  std::vector<std::int64_t> numbers_;
  std::vector<double> share_;
  std::vector<int> own_, others_;  ///< texels that are the process's own, in the order of its rows; those of the rim
};

}  // namespace mq::shared
