#pragma once
/// Parts of a texture for which photographs are chosen: squares of a few texels, each of one chart.

#include <vector>

#include "mq/fem/texels.h"
#include "mq/linear/matrix.h"

namespace mq {

struct Patches {
  std::vector<int> of;                ///< per unknown its patch
  std::vector<std::int64_t> offsets;  ///< per patch its unknowns, members[offsets[p] ... offsets[p + 1])
  std::vector<int> members;           ///< increasing within a patch

  /// Two patches that touch, on one chart or over a seam.
  struct Link {
    int a, b;      ///< a < b
    float weight;  ///< length of what they share, in sides of a patch
  };
  std::vector<Link> links;  ///< by a, then b

  int count() const { return int(offsets.size()) - 1; }
  std::int64_t size(int patch) const { return offsets[patch + 1] - offsets[patch]; }

  /// `number` of its unknowns at most, spread over it; all of them where it has no more.
  std::vector<int> samples(int patch, int number) const;
};

/// Squares of side × side texels, by the grid of the textures, which the charts cut further. Two touch as
/// their unknowns couple in the pattern of `stiffness`, a full side being 3 · side couplings, as those of
/// bilinear texels are. Throws `InvalidInput` for a side below 1 or a matrix of another size.
Patches make_patches(const Texels& texels, const SparseMatrix& stiffness, int side);

}  // namespace mq
