#pragma once
/// Which photograph a texel has: that of its patch where it shows the texel, else the next best that does.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/draw/photograph.h"
#include "mq/views/view_choice.h"

namespace mq {

/// Per patch the photographs that its texels ask, one after another: what was chosen for it, then the best; where
/// none shows it, what patches beside it are asked of. Those that are rejected come last; those of another hue than is
/// agreed on are not asked, nor are any where all are rejected, or beside such a patch.
std::vector<std::vector<int>> views_to_ask(const Patches& patches, const Observations& observations,
                                           std::span<const int> chosen);

/// Per patch the photograph of the frame before that most of its texels came from; of equals the first; `unseen` where
/// none did. Throws `InvalidInput` where there is not a number per texel.
std::vector<int> views_before(const Patches& patches, std::span<const int> before, int photographs);

/// Gives open texels the photograph that is wanted where it shows them, else the first of those that their patch
/// asks which does; `unseen` where none does.
void find_labels(const Projector& projector, const Patches& patches, const std::vector<std::vector<int>>& asked,
                 std::span<const int> wanted, std::span<const PinholeCamera> cameras, const PhotographOptions& options,
                 std::vector<int> open, std::vector<int>& labels, const Progress& progress);

/// Texels of patches that hold an unseen one, or lie beside such a patch.
std::vector<int> beside_unseen(const Patches& patches, std::span<const int> labels);

/// Takes what was found with more distance from outlines, but where no texel of a patch and of those beside it would
/// be left: what is thin is shown near its outlines or not at all.
void take_surer(const Patches& patches, std::span<const int> texels, std::span<const int> surer,
                std::vector<int>& labels);

}  // namespace mq
