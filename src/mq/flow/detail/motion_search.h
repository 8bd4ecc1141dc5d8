#pragma once
/// Motions of any length up to a third of the images, found by trying all of them where images are small.

#include <array>
#include <vector>

#include "mq/flow/detail/image_signals.h"

namespace mq {

/// Straight fields, a vector per pixel of a small grid, in pixels of it.
struct SearchedMotions {
  Image<float> free;    ///< each pixel's own
  Image<float> common;  ///< the same where motions that few pixels have cost more

  /// The motions that most pixels of `common` have, three at most.
  std::vector<std::array<float, 2>> most;
};

/// X of φ₀(p − X/2) ≈ φ₁(p + X/2) by a search of all whole X up to 0.3 of the sides, on a grid of about 60 × 60 pixels
/// p, where both signals are looked up at twice that resolution, so that p ± X/2 are pixels of theirs: for each p and
/// X the mean difference, at most `most_difference`, around p; of these labels the least after they were summed along
/// lines, where neighbours of another motion cost. A place outside one of the images costs half of the most.
///
/// Textures without much to hold on to fit many motions. So labels are counted and found again with the logarithm of
/// how rare they are as a further cost, as expectation-maximisation of a mixture's proportions would.
///
/// Swapped signals give −X, bit for bit. Empty images where the sides are shorter than `least_side`.
SearchedMotions searched_motions(const SignalPair& signals);

}  // namespace mq
