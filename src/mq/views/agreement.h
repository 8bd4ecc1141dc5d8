#pragma once
/// Whether photographs show one surface, as far as their colours tell.

#include "mq/views/view_choice.h"

namespace mq {

/// How far colours that photographs show are apart, in logarithms of light, the mean of the channels: medians over all
/// observations of patches that three views show at least.
struct Agreement {
  double here = 0;       ///< from the median of the other views of the patch
  double elsewhere = 0;  ///< ... of another patch, as if photographs had been exchanged
  double share = 0;      ///< of all observations, those that were compared

  /// Far apart, and as far as if they had been exchanged: mesh, cameras and photographs do not belong together. What is
  /// of one colour all over is near either way, and tells nothing.
  bool is_accidental() const { return share > 0.25 && here > 0.1 && here > 0.6 * elsewhere; }
};

/// Of observations whose exposure is evened out, those that are rejected too.
Agreement agreement(const Observations& observations);

}  // namespace mq
