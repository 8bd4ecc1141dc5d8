#pragma once
/// How texels change that hang on none of another frame: those that show little of the surface, as one beside them does;
/// those of surface that begins or ends, smoothly from the others on.

#include <vector>

#include "mq/linear/matrix.h"
#include "mq/video/detail/time_links.h"

namespace mq {

/// Per unknown of less than half the mass of one that `coupled` has an entry for, the one of these
/// with the most, or that one's leader; −1: it shows enough of the surface to have a change of its
/// own. At a straight border those are the texels whose centres lie in the chart.
std::vector<int> change_leaders(const SparseMatrix& coupled, const Vector& mass);

/// Links of changes. A texel that is the same in both frames keeps its link. Of the others those
/// with a leader have none, and what is interpolated from a texel with a leader comes from that.
TimeLinks led_links(const TimeLinks& links, const std::vector<int>& leaders,
                    const std::vector<int>& leaders_before);

/// Adds Σ strength · min(m_i, m_j) (δ_i − δ_j)² over pairs that K couples, one of which is `chosen`.
void add_differences(const std::vector<char>& chosen, const Vector& mass, double strength, SparseMatrix& K);

}  // namespace mq
