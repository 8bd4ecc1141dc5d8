#pragma once
/// Texels at seams, chosen by several processes as `smooth_at_seams` chooses them.

#include <vector>

#include "mq/filter/seam_rows.h"
#include "mq/filter/seam_values.h"
#include "numbering.h"

namespace mq::shared {

/// The least and the greatest that any process has, of its own rows that count (1). Every process must call it.
ValueRange shared_range(const Processes& processes, const TexelPart& part, const Signal& values,
                        const std::vector<char>& counts);

/// The signal with new values at the unknowns that are `free` (1), in the own rows. `psi` has the rows of the part's
/// space, those of the halo filled; `free` those of its own. The part's space must have been made with `soft_seams`. The
/// thin system around seams is factored by all processes together. Every process must call it.
Filtered shared_smooth_at_seams(const Processes& processes, const TexelPart& part, const Numbering& numbering,
                                const Signal& psi, const std::vector<char>& free, Smooth what);

}  // namespace mq::shared
