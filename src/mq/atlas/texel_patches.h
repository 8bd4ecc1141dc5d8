#pragma once
/// Texels that hang together, for people who want to find them in a picture.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/atlas/texel_grid.h"
#include "mq/base/defect.h"

namespace mq {

/// Texels beside each other in a row: columns from `first` to `last`.
struct TexelRun {
  int texture = 0, row = 0, first = 0, last = 0;
};

/// The runs of texels that are numbered as `TexelGrid` numbers them, in any order, some perhaps twice.
std::vector<TexelRun> texel_runs(const TexelGrid& grid, std::vector<std::int64_t> texels);

/// Patches of texels that touch each other, at corners too; the largest first, of equals the first row by
/// row. Each with the texel of its own that is nearest to its middle. Runs are sorted by texture, row and
/// column and apart from each other. What touches over the border of a repeated texture stays apart.
std::vector<Defect::Place> texel_patches(std::span<const TexelRun> runs);

/// Lists where these texels are, as `texel_patches` finds them, at most `Defect::max_places`.
void list_places(const TexelGrid& grid, std::vector<std::int64_t> texels, Defect& defect);

}  // namespace mq
