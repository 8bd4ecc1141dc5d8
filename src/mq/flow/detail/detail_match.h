#pragma once
/// Whether what a field brings together is the same thing.

#include <vector>

#include "mq/flow/detail/image_signals.h"

namespace mq {

/// A field of much freedom brings values of anything near to each other, by bending. So two measures that it is not chosen by.
struct DetailMatch {
  double alike = 1;  ///< the share of pixels with detail whose detail is alike along the field; 1 where hardly any has
  double bend = 0;   ///< the median of |∇X − M|, M the median of ∇X: 0 where all moves, turns and grows as one
};

/// Detail is what is finer than a Gaussian of 1 % of √area. A pixel that is `seen` in both images has it if it is
/// stronger than a twentieth of the deviation of the signals, and its variance three times that of the flattest tenth of all
/// pixels, which noise has too; and it is alike if it correlates by more than a half in
/// the two around the pixel (Gaussian of 1.2 %). X is a straight field halfway, and its slopes are taken of what is
/// smoothed by 1 %. Of the same thing that moves, turns and grows 0.8 and more is alike, and the bend 0.02 to 0.2; of
/// different things at most 0.3, and the bend 0.4 and more.
DetailMatch detail_match(const SignalPair& signals, const Image<float>& X, const std::vector<char>& seen);

}  // namespace mq
